"""Families of measures: one parameter makes a measure of each, as in `steps_after: 30`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_functions import (
    FINAL_TRIALS,
    NEAR,
    converged,
    final_over_optimum,
    gap_level,
    share,
)
from rl_design_space.learning.measure_kinds import CurveMeasure, Measure, PeriodMeasure, Periods


@dataclass(frozen=True)
class Family:
    """Measures that differ in one parameter.

    Attributes:
        usual: value of the parameter if none is given; its type is that of the others.
        expected: what values are allowed, for messages.
        allows: whether a value is allowed.
        make: the measure of a value.
    """

    usual: float
    expected: str
    allows: Callable[[float], bool]
    make: Callable[[Any], Measure]

    def value(self, name: str, given: Any) -> float:
        """Return the parameter of a measure of this family.

        Raises:
            ConfigError: the value is not allowed.
        """
        if given is None:
            return self.usual
        number = isinstance(given, int | float) and not isinstance(given, bool)
        if not number or not self.allows(given):
            raise ConfigError.at(name, given, f"should be {self.expected}")
        return type(self.usual)(given)


def _steps_after(trial: int) -> Measure:
    def steps(periods: Periods) -> FloatArray:
        trials = periods.steps.shape[1]
        if trial >= trials:
            raise ConfigError.at("steps_after", trial, f"there are {trials} trials; should be less")
        total: FloatArray = periods.steps[:, trial:].sum(axis=1, dtype=np.float64)
        return total

    return PeriodMeasure(f"steps of the trials from trial {trial} on, counted from 0", steps)


def _gap_closed(closed: float) -> Measure:
    what = (
        f"first trial from which on the {{}} curve of steps / optimum has closed {closed:.15g} of the gap between the "
        "first trial and the optimum, and stays there"
    )
    return CurveMeasure(what, lambda curves: converged(curves, gap_level(curves, closed), 1), is_first_trial=True)


def _trials_to(factor: float) -> Measure:
    what = f"first trial from which on the {{}} curve of steps / optimum stays within {factor:.15g}"
    return CurveMeasure(
        what, lambda curves: converged(curves, np.ones_like(curves[..., :1]), factor), is_first_trial=True
    )


def _near_share(factor: float) -> Measure:
    return PeriodMeasure(
        f"share of periods whose last {FINAL_TRIALS} trials need at most {factor:.15g} times the optimum, on average",
        lambda periods: share(final_over_optimum(periods) <= factor),
        largest_is_best=True,
        of_shares=True,
    )


def _solved_within(factor: float) -> Measure:
    return PeriodMeasure(
        f"share of trials that reach the final goal within {factor:.15g} times the fewest steps possible",
        lambda periods: share((periods.success & (periods.over_optimum <= factor)).mean(axis=1)),
        largest_is_best=True,
        of_shares=True,
    )


def _is_trial(value: float) -> bool:
    return 0 <= value < np.inf and value == int(value)


_FACTOR = "a factor of at least 1"
#: By name.
FAMILIES: Mapping[str, Family] = {
    "steps_after": Family(30, "a trial, a whole number from 0", _is_trial, _steps_after),
    "gap_closed": Family(0.9, "a share above 0, up to 1", lambda value: 0 < value <= 1, _gap_closed),
    "trials_to": Family(NEAR, _FACTOR, lambda value: 1 <= value < np.inf, _trials_to),
    "near_share": Family(NEAR, _FACTOR, lambda value: 1 <= value < np.inf, _near_share),
    "solved_within": Family(2.0, _FACTOR, lambda value: 1 <= value < np.inf, _solved_within),
}
