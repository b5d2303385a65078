"""Estimates with their uncertainty. The unit is the period."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
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


def top_percent_weight(values: FloatArray) -> float:
    """Mean of the largest 1 % of the values over the mean of all: 1 if all are equal, large in a heavy tail.

    Args:
        values: (periods,) not negative; the 1 % is rounded up to whole periods.
    """
    largest = np.sort(values)[-math.ceil(len(values) / 100) :]
    return float(largest.mean() / values.mean())
