"""Fit of measured cells of a table to published ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, Resamples, percentile_interval, weighted_means


@dataclass(frozen=True)
class Fit:
    """Distance of the cells of a table from the published ones, in logarithms, so that half and twice are equally far.

    Attributes:
        rms: root of the mean squared log ratio, measured / published.
        bias: mean log ratio; positive if the measured cells are too large.
        largest: largest absolute log ratio.
    """

    rms: Estimate
    bias: Estimate
    largest: float


def fit(cells: Sequence[tuple[FloatArray, float]]) -> Fit:
    """Return the fit of cells, with 95 % bootstrap intervals over periods.

    The rms is biased upwards, and so is its interval: even cells that fit perfectly differ by chance.

    Args:
        cells: for each cell the values of its periods, (periods,), and the published number.
    """
    plain, resampled = [], []
    for values, published in cells:
        plain.append(np.log(values.mean() / published))
        means = [weighted_means(weights, values) for weights in Resamples(len(values)).blocks()]
        resampled.append(np.log(np.concatenate(means) / published))
    ratios, samples = np.array(plain), np.array(resampled)  # (cells,), (cells, resamples)
    return Fit(
        rms=_estimate(np.sqrt((ratios**2).mean()), np.sqrt((samples**2).mean(axis=0))),
        bias=_estimate(ratios.mean(), samples.mean(axis=0)),
        largest=float(np.abs(ratios).max()),
    )


def _estimate(value: float, samples: FloatArray) -> Estimate:
    low, high = percentile_interval(samples)
    return Estimate(float(value), float(low), float(high))
