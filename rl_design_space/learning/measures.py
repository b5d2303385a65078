"""Measures: numbers and curves that are computed from the periods of a point.

This table serves recorded scalars, the values of reports (`--value`), claims (`measure:`), frames of runs and summaries
of curves. `measure` returns one by its name, with parameters and a statistic if there are any: docs/reports.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_families import FAMILIES
from rl_design_space.learning.measure_functions import (
    FINAL_TRIALS,
    NEAR,
    OUTLIER,
    converged,
    final_over_optimum,
    gap_left,
    roughness,
    scaled_to_equal_steps,
    second_half,
    share,
)
from rl_design_space.learning.measure_kinds import CurveMeasure, Measure, PeriodMeasure, Periods
from rl_design_space.learning.measure_spec import MeasureSpec, Spec, parsed
from rl_design_space.learning.measure_statistics import MEAN
from rl_design_space.learning.own_measure import own_measure
from rl_design_space.learning.stage_measure import STAGE, of_stage

__all__ = [
    "ALIASES",
    "CURVES",
    "CURVES_OF_PERIODS",
    "CURVES_ON_DEMAND",
    "FINAL_TRIALS",
    "MEASURES",
    "NEAR",
    "ONLY_SCALARS",
    "OUTLIER",
    "SCALARS",
    "CurveMeasure",
    "Measure",
    "PeriodMeasure",
    "Periods",
    "Spec",
    "canonical",
    "converged",
    "forms",
    "measure",
    "scaled_to_equal_steps",
    "values",
]

#: Names of the learning curves that are recorded for every point.
CURVES = ("steps/mean", "steps/median", "success_rate")
#: Names of the learning curves that are recorded on demand; the artifact of a run always holds them.
CURVES_ON_DEMAND = ("steps/q10", "steps/q90", "steps/over_optimum", "epsilon")
#: Names of the recorded scalars, see `LearningCurves.scalars`.
SCALARS = (
    "total_steps",
    "total_steps_sem",
    "total_steps_scaled",
    "failed_trials",
    "failed_periods",
    "final_steps_over_optimum",
    "env_steps_per_second",
)
#: Recorded scalars that are not computed from the periods alone, or not by a measure.
ONLY_SCALARS = ("total_steps_sem", "env_steps_per_second")

MEASURES: Mapping[str, Measure] = {
    "total_steps": PeriodMeasure("steps of all trials of a period", lambda periods: periods.total_steps),
    "total_steps_scaled": PeriodMeasure(
        "total steps · 10/d, steps of equal length on square grids of any size d",
        lambda periods: periods.scaled_steps,
    ),
    "late_steps": PeriodMeasure(
        "steps of a trial in the second half of the trials", lambda periods: second_half(periods.steps)
    ),
    "failed_trials": PeriodMeasure(
        "share of trials that miss the final goal",
        lambda periods: 1 - share(periods.success.mean(axis=1)),
        of_shares=True,
    ),
    "solved": PeriodMeasure(
        "share of trials that reach the final goal",
        lambda periods: share(periods.success.mean(axis=1)),
        largest_is_best=True,
        of_shares=True,
    ),
    "failed_periods": PeriodMeasure(
        "share of periods with a trial that misses the final goal",
        lambda periods: 1 - share(periods.success.all(axis=1)),
        of_shares=True,
    ),
    "final_steps_over_optimum": PeriodMeasure(f"steps / optimum in the last {FINAL_TRIALS} trials", final_over_optimum),
    "final_failed": PeriodMeasure(
        f"share of the last {FINAL_TRIALS} trials that miss the final goal",
        lambda periods: share((~periods.success[:, -FINAL_TRIALS:]).mean(axis=1)),
        of_shares=True,
    ),
    "not_near_optimum": PeriodMeasure(
        f"share of periods whose last {FINAL_TRIALS} trials need more than {NEAR} times the optimum",
        lambda periods: share(final_over_optimum(periods) > NEAR),
        of_shares=True,
    ),
    "outliers": PeriodMeasure(
        f"share of trials in the second half that need more than {OUTLIER} times the optimum",
        lambda periods: second_half(periods.over_optimum > OUTLIER),
        of_shares=True,
    ),
    "trials_to_final": CurveMeasure(
        f"trials until the {{}} curve of steps / optimum stays within {NEAR} times its own final level: a curve that "
        "ends worse is faster by it; trials_to and gap_closed count against the optimum",
        lambda curves: converged(curves, curves[..., -FINAL_TRIALS:].mean(axis=-1, keepdims=True)),
        is_first_trial=True,
    ),
    "trials_to_optimum": CurveMeasure(
        f"trials until the {{}} curve of steps / optimum stays within {NEAR}",
        lambda curves: converged(curves, np.ones_like(curves[..., :1])),
        is_first_trial=True,
    ),
    "gap_left": CurveMeasure(
        "share of the gap between the first trial and the optimum, on the {} curve of steps / optimum, that is left in "
        f"the last {FINAL_TRIALS} trials",
        gap_left,
    ),
    "roughness": CurveMeasure(
        "mean absolute second difference of the logarithm of the {} curve of steps / optimum", roughness
    ),
}
#: Alternative names of measures.
ALIASES = {"final_over_optimum": "final_steps_over_optimum"}
#: Learning curves that are means over periods, by name, and (periods, trials) values that they are means of.
CURVES_OF_PERIODS: Mapping[str, Callable[[Periods], NDArray[Any]]] = {
    "steps/mean": lambda periods: periods.steps,
    "steps/over_optimum": lambda periods: periods.over_optimum,
    "success_rate": lambda periods: periods.success,
}


def measure(spec: Spec) -> Measure:
    """Return a measure.

    Args:
        spec: its name, `total_steps`; with the parameter of a family, `steps_after=30` or `{steps_after: 30}`; module
            and function of the user's own, `my_module.my_measure,parameter=3` or
            `{_target_: my_module.my_measure, parameter: 3}`; each with a statistic if it should not be the mean,
            `steps_after=30,statistic=median` or `{steps_after: 30, statistic: median}`; but for those of the user's own
            with a stage if it should be of this stage alone, `solved,stage=2` or `{solved: null, stage: last}`.

    Raises:
        ConfigError: there is no such measure, or a parameter or the statistic is not allowed.
    """
    return _of_spec(parsed(spec))


def canonical(spec: Spec) -> str:
    """Return the name of a measure in files and columns: its text form, with its parameter; two names are never one.

    A function of the user's own is not imported.

    Raises:
        ConfigError: there is no such measure, or a parameter or the statistic is not allowed.
    """
    found = parsed(spec)
    if not found.is_own:
        _of_spec(found)
        if found.name in FAMILIES:
            found = replace(found, value=FAMILIES[found.name].value(found.name, found.value))
    return found.text


def values(names: Iterable[str], periods: Periods) -> dict[str, float]:
    """Return measures of a point by their names.

    Raises:
        ConfigError: there is no such measure, or it cannot be computed.
    """
    return {name: _value(measure(name), periods) for name in names}


def forms() -> dict[str, str]:
    """Return the meaning of each measure by its name, that of a family with its usual parameter: `steps_after=30`."""
    families = [canonical(name) for name in FAMILIES]
    return {name: measure(name).meaning for name in (*MEASURES, *families)}


def _value(measured: Measure, periods: Periods) -> float:
    each = measured.each(periods)
    if each is not None:
        return float(each.mean())
    count = len(periods.steps)
    return float(measured.samples(periods, np.full((1, count), 1 / count))[0])


def _of_spec(spec: MeasureSpec) -> Measure:
    found = _plain(spec)
    return found if spec.statistic == MEAN.name else found.with_statistic(spec.statistic)


def _plain(spec: MeasureSpec) -> Measure:
    """Return the measure of a specification, with the mean as its statistic."""
    if spec.is_own:
        if spec.value is not None:
            raise ConfigError.at(spec.name, spec.value, "should name the parameter: my_module.my_measure,parameter=3")
        return own_measure(spec.name, spec.parameters)
    name = ALIASES.get(spec.name, spec.name)
    if name not in MEASURES and name not in FAMILIES:
        raise ConfigError.unknown("measure", spec.name, (*MEASURES, *FAMILIES))
    if others := [parameter for parameter in spec.parameters if parameter != STAGE]:
        unknown = ConfigError.unknown("parameter", others[0], ("statistic", STAGE))
        raise ConfigError(f"measure {spec.name}: {unknown}")
    if name in FAMILIES:
        found = FAMILIES[name].make(FAMILIES[name].value(name, spec.value))
    elif spec.value is not None:
        raise ConfigError.at(spec.name, spec.value, "takes no parameter")
    else:
        found = MEASURES[name]
    return of_stage(found, spec.parameters[STAGE]) if STAGE in spec.parameters else found
