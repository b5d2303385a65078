"""Estimates with their uncertainty. The unit is the period."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from rl_design_space._arrays import FloatArray

RESAMPLES = 5000


class Estimate(NamedTuple):
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


def mean_estimate(values: FloatArray, seed: int = 0) -> Estimate:
    """Mean of independent periods with a bias-corrected and accelerated (BCa) bootstrap interval.

    BCa follows the skew of heavy tails (Efron, "Better bootstrap confidence intervals", JASA 82, 1987).

    Args:
        values: (periods,) one number a period.
        seed: of the resampling.
    """
    mean = float(np.mean(values))
    if len(values) < 2:
        return Estimate(mean, np.nan, np.nan)
    if np.ptp(values) == 0:
        return Estimate(mean, mean, mean)
    rng = np.random.default_rng(seed)
    interval = stats.bootstrap((values,), np.mean, n_resamples=RESAMPLES, method="BCa", rng=rng).confidence_interval
    return Estimate(mean, float(interval.low), float(interval.high))


def share_estimate(which: NDArray[np.bool_]) -> Estimate:
    """Share of periods of which something is true, with its Wilson interval (JASA 22, 1927).

    Args:
        which: (periods,)
    """
    interval = stats.binomtest(int(which.sum()), len(which)).proportion_ci(method="wilson")
    return Estimate(float(which.mean()), float(interval.low), float(interval.high))


def top_percent_weight(values: FloatArray) -> float:
    """Mean of the largest 1 % of the values over the mean of all: 1 if all are equal, large in a heavy tail.

    Args:
        values: (periods,) not negative; the 1 % is rounded up to whole periods.
    """
    largest = np.sort(values)[-math.ceil(len(values) / 100) :]
    return float(largest.mean() / values.mean())


@lru_cache(maxsize=4)
def resample_weights(periods: int, seed: int = 0, resamples: int = RESAMPLES) -> FloatArray:
    """How much each period counts in each bootstrap resample.

    A weighted sum over periods is a resampled mean: `weights @ values`, for many columns of values at a time. Points
    of equal size and seed met the same layouts, so their differences are paired: the same weights resample both.

    Returns:
        (resamples, periods), each row sums to 1.
    """
    rng = np.random.default_rng(seed)
    weights: FloatArray = rng.multinomial(periods, np.full(periods, 1 / periods), size=resamples) / periods
    weights.setflags(write=False)  # shared by all who ask for them
    return weights


def percentile_interval(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The middle 95 % of bootstrap samples, along the first axis."""
    low, high = np.percentile(samples, (2.5, 97.5), axis=0)
    return low, high
