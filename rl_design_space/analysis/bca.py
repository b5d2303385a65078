"""Bias-corrected and accelerated (BCa) bootstrap intervals of means.

They are those of `scipy.stats.bootstrap`, bit for bit. To import `scipy.stats` takes a second, in which a report with
hundreds of intervals could be written, and its bootstrap twice the time for each interval.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import ndtr, ndtri

from rl_design_space._arrays import FloatArray

#: Probability outside of an interval, at each end.
_OUTSIDE = (1 - 0.95) / 2


def bca_interval(values: FloatArray, means: FloatArray) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a mean (Efron, "Better bootstrap confidence intervals", JASA 82, 1987).

    Args:
        values: (periods,), not all equal.
        means: (resamples,) mean of each bootstrap resample.

    Returns:
        Both ends; NaN if the mean lies outside of all resampled ones.
    """
    mean, outside = values.mean(), float(ndtri(_OUTSIDE))
    below = np.count_nonzero(means < mean) + np.count_nonzero(means <= mean)
    bias = ndtri(below / (2 * len(means)))
    if not math.isfinite(bias):
        return math.nan, math.nan
    skew, ordered = _acceleration(values), np.sort(means)
    low, high = (
        _quantile(ordered, float(ndtr(bias + away / (1 - skew * away)))) for away in (bias + outside, bias - outside)
    )
    return low, high


def _acceleration(values: FloatArray) -> float:
    """Return a sixth of the skewness of a mean, from the means without one period each."""
    periods = len(values)
    # All values but one of each row: what follows the first value, in rows that are longer by one, is never left out.
    others = np.tile(values, periods)[1:].reshape(periods - 1, periods + 1)[:, :-1].reshape(periods, periods - 1)
    without = others.mean(axis=-1)
    away = (periods - 1.0) * (without.mean() - without)
    cubes, squares = (away**3).sum() / float(periods) ** 3, (away**2).sum() / float(periods) ** 2
    return float(1 / 6 * cubes / squares ** (3 / 2))


def _quantile(ordered: FloatArray, share: float) -> float:
    """Return a quantile, between two values by linear interpolation."""
    place = share * len(ordered) + (1 - share)
    above = min(int(place), len(ordered) - 1)
    part = place % 1 if place >= 1 else 0.0
    return float((1 - part) * ordered[max(int(place) - 1, 0)] + part * ordered[above])
