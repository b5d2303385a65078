"""Likelihood of published numbers under a reading of the text that they come from.

Definition, written down before any number was looked at:

- A published number y is the mean of P periods; x₁ … x_N are the periods measured for its cell under a reading.
- The density of log y is the saddlepoint approximation over the measured periods (Daniels, "Saddlepoint approximations
  in statistics", Ann. Math. Stat. 25, 1954; for resampled means Davison and Hinkley, Biometrika 75, 1988): with
  K(t) = log mean exp(t·x) and K'(t) = y it is proportional to y·√(P / K''(t))·exp(P·(K(t) − t·y)), normalised. This
  is a smooth density of resampled means of size P, also far from their middle, where none would be drawn.
- The mean of the reading is known from N periods alone, and is off by as much again as the mean of N periods is. So
  P·N / (P + N) periods stand for P.
- With probability `STRAY` a published number is anything within a factor of 10 of what it is: a misprint, or something
  that no reading describes. That is the floor: no cell counts against a reading without limit, a number outside of the
  measured periods neither.
- The log likelihood of a reading is the sum over the cells of all panels, at the P that makes it largest. One P holds
  for all cells; the paper does not name the P of its table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from rl_design_space._arrays import FloatArray

#: Numbers of periods of a published mean that are tried.
PERIODS = (100, 150, 200, 300, 400, 500, 700, 1000, 1400, 2000)
#: Probability that a published number is anything within a factor of 10.
STRAY = 0.01
_STRAY_DENSITY = 1 / (2 * math.log(10))
#: Tilts in units of one over a standard deviation, close together around 0, and the part of the axis around each.
_STEPS = np.linspace(-15, 15, 241)
_TILTS, _WIDTHS = np.sinh(_STEPS) / 30, np.cosh(_STEPS) / 30 * (_STEPS[1] - _STEPS[0])


@dataclass(frozen=True)
class JointFit:
    """Fit of a reading to the panels of a table.

    Attributes:
        total: log likelihood of all cells.
        panels: the part of each panel.
        periods: the number of periods of a published mean at which it is largest.
        at: log likelihood of all cells by the number of periods.
    """

    total: float
    panels: Mapping[str, float]
    periods: int
    at: Mapping[int, float]


def joint_fit(panels: Mapping[str, FloatArray], periods: Sequence[int] = PERIODS) -> JointFit:
    """Return the fit of a reading.

    Args:
        panels: log densities of the cells of each panel, (cells, periods), see `log_density`.
        periods: the numbers of periods that the columns stand for.
    """
    sums = {panel: cells.sum(axis=0) for panel, cells in panels.items()}
    total = np.sum(list(sums.values()), axis=0)
    best = int(np.argmax(total))
    parts = {panel: float(part[best]) for panel, part in sums.items()}
    return JointFit(float(total[best]), parts, periods[best], dict(zip(periods, total.tolist(), strict=True)))


def log_density(
    published: float, values: FloatArray, periods: Sequence[int] = PERIODS, stray: float = STRAY
) -> FloatArray:
    """Return the log density of the logarithm of a published number, (periods,).

    Args:
        published: the number.
        values: (N,) of the measured periods, positive.
        periods: the numbers of periods of the published mean.
        stray: probability that the number has nothing to do with the reading.
    """
    sizes = np.array(periods, dtype=float)
    inside = _log_saddlepoint(published, values, sizes * len(values) / (sizes + len(values)))
    floor = math.log(stray * _STRAY_DENSITY) if stray else -math.inf
    mixed: FloatArray = np.logaddexp(math.log1p(-stray) + inside, floor)
    return mixed


def _log_saddlepoint(published: float, values: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return the log density of the logarithm of means of these sizes; −∞ at numbers that no mean comes near."""
    nowhere = np.full(len(sizes), -np.inf)
    if not values.min() < published < values.max():
        return nowhere
    spread = values.std()
    scaled = (values - values.mean()) / spread
    at = float((published - values.mean()) / spread)
    levels, means, curvatures = _cumulants(_TILTS, scaled)
    after = int(np.searchsorted(means, at))
    if not 0 < after < len(means):
        return nowhere
    from scipy.optimize import brentq  # which takes as long as all of these

    tilt = brentq(lambda tilt: float(_cumulants(np.array([tilt]), scaled)[1][0]) - at, *_TILTS[after - 1 : after + 1])
    (level,), _, (curvature,) = _cumulants(np.array([tilt]), scaled)
    # The mass of the density before it is normalised is the integral of √(P·K'')·exp(P·(K − t·K')) over the tilts.
    heights = np.log(curvatures) / 2 + sizes[:, None] * (levels - _TILTS * means)
    mass = logsumexp(heights + np.log(_WIDTHS), axis=1)
    height = sizes * (level - tilt * at) - math.log(curvature) / 2
    density: FloatArray = height - mass + math.log(published / spread)
    return density


def _cumulants(tilts: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return K, K' and K'' of values at tilts, (tilts,) each."""
    exponents = np.multiply.outer(tilts, values)
    largest = exponents.max(axis=1)
    weights = np.exp(exponents - largest[:, None])
    total = weights.sum(axis=1)
    means = weights @ values / total
    variances = weights @ values**2 / total - means**2
    return np.log(total / len(values)) + largest, means, np.maximum(variances, np.finfo(float).tiny)
