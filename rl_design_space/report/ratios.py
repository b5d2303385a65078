"""Ratios of means over the same periods."""

from __future__ import annotations

from collections.abc import Mapping

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, percentile_interval, resample_weights
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves


def of_periods(result: LearningCurves, name: str) -> FloatArray:
    """Return a measure that is a mean over periods, of each period."""
    values = measure(name).each(result)
    assert values is not None
    return values


def ratio(values: FloatArray, others: FloatArray) -> Estimate:
    """Return the ratio of two means over the periods that both have, with its bootstrap interval over periods."""
    common = min(len(values), len(others))
    values, others, weights = values[:common], others[:common], resample_weights(common)
    low, high = percentile_interval(weights @ values / (weights @ others))
    return Estimate(float(values.mean() / others.mean()), float(low), float(high))


def named(name: str, estimate: Estimate) -> Mapping[str, float]:
    """Return an estimate as columns of a frame."""
    return {name: estimate.value, f"{name}_low": estimate.low, f"{name}_high": estimate.high}
