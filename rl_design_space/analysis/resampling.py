"""Bootstrap samples of periods, and intervals from them; needs NumPy alone."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rl_design_space._arrays import FloatArray

RESAMPLES = 5000


class Estimate(NamedTuple):
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


@lru_cache(maxsize=4)
def resample_weights(periods: int, seed: int = 0, resamples: int = RESAMPLES) -> FloatArray:
    """Return the weight of each period in each bootstrap resample.

    A weighted sum over periods is a resampled mean: `weights @ values`, for many columns of values at a time. Points of
    equal size and seed have the same layouts, so their differences are paired: the same weights resample both.

    Returns:
        (resamples, periods), each row sums to 1.
    """
    rng = np.random.default_rng(seed)
    weights: FloatArray = rng.multinomial(periods, np.full(periods, 1 / periods), size=resamples) / periods
    weights.setflags(write=False)  # cached, so it is shared
    return weights


def percentile_interval(samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the middle 95 % of bootstrap samples, along the first axis."""
    low, high = np.percentile(samples, (2.5, 97.5), axis=0)
    return low, high
