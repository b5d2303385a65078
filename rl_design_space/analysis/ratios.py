"""Ratios of a measure of two results with the same layouts, with their intervals."""

from __future__ import annotations

from rl_design_space.analysis.parts.measured import measured, value, weightings
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.analysis.tested import interval
from rl_design_space.learning.result import LearningCurves


def ratio_of(name: str, one: LearningCurves, other: LearningCurves) -> Estimate:
    """Return a measure of a result over that of another, with its 95 % bootstrap interval over paired periods.

    Args:
        name: of the measure.
        one: a result.
        other: a result with the same layouts, period by period.

    Raises:
        ConfigError: they have different numbers of periods.
    """
    plain, samples = (measured(name, one, each).over(measured(name, other, each)) for each in weightings(one))
    return Estimate(float(plain.low[0]), *interval(samples))


def plain_ratio(name: str, one: LearningCurves, other: LearningCurves) -> float:
    """Return a measure of a result over that of another; medians of resamples would take long."""
    return value(name, one) / value(name, other)
