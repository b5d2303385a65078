"""How well measured cells fit published ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, percentile_interval, resample_weights


@dataclass(frozen=True)
class Fit:
    """How far the cells of a table lie from the published ones, in logarithms, so that half and twice are equally far.

    Attributes:
        rms: root of the mean squared log ratio, measured / published.
        bias: mean log ratio: above 0 if the measured cells are too large.
        largest: largest absolute log ratio.
    """

    rms: Estimate
    bias: Estimate
    largest: float


def fit(cells: Sequence[tuple[FloatArray, float]]) -> Fit:
    """The fit of some cells, with 95 % bootstrap intervals over periods.

    The interval of the rms is that of rms itself, which chance makes larger than it is, not smaller: cells that fit
    perfectly would still differ by chance.

    Args:
        cells: of each cell the values of its periods, (periods,), and the published number.
    """
    plain, resampled = [], []
    for values, published in cells:
        weights = resample_weights(len(values))
        plain.append(np.log(values.mean() / published))
        resampled.append(np.log(weights @ values / published))
    ratios, samples = np.array(plain), np.array(resampled)  # (cells,), (cells, resamples)
    return Fit(
        rms=_estimate(np.sqrt((ratios**2).mean()), np.sqrt((samples**2).mean(axis=0))),
        bias=_estimate(ratios.mean(), samples.mean(axis=0)),
        largest=float(np.abs(ratios).max()),
    )


def _estimate(value: float, samples: FloatArray) -> Estimate:
    low, high = percentile_interval(samples)
    return Estimate(float(value), float(low), float(high))
