"""Estimates with their uncertainty; the unit is the period."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bca import bca_interval
from rl_design_space.analysis.resampling import (
    RESAMPLES,
    Estimate,
    Resamples,
    percentile_interval,
    resample_weights,
    resampled_means,
)
from rl_design_space.learning.measure_statistics import weighted_means

__all__ = [
    "RESAMPLES",
    "Estimate",
    "Resamples",
    "mean_estimate",
    "mean_share_estimate",
    "percentile_interval",
    "resample_weights",
    "resampled_means",
    "share_estimate",
    "top_percent_weight",
    "weighted_means",
]

#: Number of periods above which the interval of a mean is computed without resampling.
_MANY = 2000
#: Skewness of a mean below which it counts as symmetric.
_NO_SKEW = 1e-6
#: Quantiles of the standard normal distribution at both ends of an interval.
_ENDS: FloatArray = ndtri((0.025, 0.975))
#: Resampled values that fit into the cache of a core.
_IN_CACHE = 50_000


def mean_estimate(values: FloatArray, seed: int = 0) -> Estimate:
    """Return the mean of independent periods with a bias-corrected and accelerated (BCa) bootstrap interval.

    BCa follows the skew of heavy tails (Efron, "Better bootstrap confidence intervals", JASA 82, 1987). Of more than
    2,000 periods the interval is analytic, which takes no resampling and holds the true mean more often (Hall, "On the
    removal of skewness by transformation", JRSS B 54, 1992). docs/decisions/0023-heavy-tails.md says how often.

    Args:
        values: (periods,) a number for each period.
        seed: seed of the resampling.
    """
    mean = float(np.mean(values))
    if len(values) < 2:
        return Estimate(mean, np.nan, np.nan)
    if np.ptp(values) == 0:
        return Estimate(mean, mean, mean)
    if len(values) > _MANY:
        return Estimate(mean, *_transformed(values))
    return Estimate(mean, *bca_interval(values, _resampled_means(values, seed)))


def _transformed(values: FloatArray) -> tuple[float, float]:
    """Return the ends of the interval of a mean from a transformation of its t-statistic that removes its skew.

    The transformation is g(t) = t + c·t²/3 + c²·t³/27 + c/6, of which c = skewness / √n (Hall, section 2).
    """
    away = values - values.mean()
    spread = float(np.sqrt((away**2).mean()))
    c = float((away**3).mean()) / spread**3 / math.sqrt(len(values))
    t = _ENDS if abs(c) < _NO_SKEW else 3 / c * (np.cbrt(1 + c * (_ENDS - c / 6)) - 1)
    high, low = values.mean() - spread / math.sqrt(len(values)) * t
    return float(low), float(high)


def share_estimate(which: NDArray[np.bool_]) -> Estimate:
    """Return the share of periods with a property, with its Wilson interval (JASA 22, 1927).

    Args:
        which: (periods,) whether each period has the property.
    """
    periods, number, z = len(which), int(which.sum()), float(_ENDS[1])
    share, width = number / periods, 2 * (periods + z**2)
    middle = (2 * periods * share + z**2) / width
    reach = z / width * math.sqrt(4 * periods * share * (1 - share) + z**2)
    low, high = (0.0 if number == 0 else middle - reach), (1.0 if number == periods else middle + reach)
    return Estimate(float(which.mean()), low, high)


def mean_share_estimate(values: FloatArray) -> Estimate:
    """Return the mean of shares with its interval: that of Wilson if each is 0 or 1, since resampling 0 of n gives 0.

    Args:
        values: (periods,) a share for each period, such as that of its trials that fail.
    """
    return share_estimate(values > 0) if np.isin(values, (0, 1)).all() else mean_estimate(values)


def top_percent_weight(values: FloatArray) -> float:
    """Return the mean of the largest 1 % of the values over the mean of all: 1 if all are equal, large for heavy tails.

    Args:
        values: (periods,) non-negative; the 1 % is rounded up to whole periods.
    """
    largest = np.sort(values)[-math.ceil(len(values) / 100) :]
    return float(largest.mean() / values.mean())


def _resampled_means(values: FloatArray, seed: int) -> FloatArray:
    """Return the mean of each bootstrap resample, (resamples,), bit for bit as `scipy.stats.bootstrap` computes it."""
    drawn = _drawn(len(values), seed, RESAMPLES)
    rows = max(1, _IN_CACHE // len(values))
    blocks = (drawn[begin : begin + rows] for begin in range(0, len(drawn), rows))
    return np.concatenate([np.take(values, block).mean(axis=-1) for block in blocks])


@lru_cache(maxsize=2)
def _drawn(periods: int, seed: int, resamples: int) -> NDArray[np.unsignedinteger[Any]]:
    """Return the periods of each bootstrap resample, (resamples, periods).

    Hundreds of intervals of a report draw the same ones, which takes longer than to average what was drawn.
    """
    picked = np.random.default_rng(seed).integers(periods, size=(resamples, periods))
    drawn: NDArray[np.unsignedinteger[Any]] = picked.astype(np.min_scalar_type(periods))  # a quarter of the memory
    drawn.setflags(write=False)  # cached, so it is shared
    return drawn
