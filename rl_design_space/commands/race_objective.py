"""The measure that decides a race, checked before anything is learned."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rl_design_space.design.curriculum import stages_of
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_spec import parsed
from rl_design_space.learning.measures import ONLY_SCALARS, CurveMeasure, Measure, PeriodMeasure, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.stage_record import StageRecord
from rl_design_space.plan.plan import Plan

#: Periods of a made-up result.
_PERIODS = 2


def mean_measure(name: str) -> Measure:
    """Return a measure that is a mean over periods.

    Raises:
        ConfigError: it is none.
    """
    if name in ONLY_SCALARS:
        raise no_mean(name)
    found = measure(name)
    if isinstance(found, CurveMeasure) or (isinstance(found, PeriodMeasure) and not found.statistic.is_mean):
        raise no_mean(name)
    return found


def no_mean(name: str) -> ConfigError:
    """Return the error about a measure that is no mean over periods."""
    expected = "a race compares means over periods, such as total_steps or steps_after=30"
    return ConfigError.at("objective", name, expected)


def check_objective(name: str, plan: Plan) -> None:
    """Refuse an objective that cannot be computed from all points: a trial or a stage that one does not have.

    A function of the user's own is not called: it may expect more of a result than its size.

    Raises:
        ConfigError: it is no mean over periods, or cannot be computed.
    """
    found = mean_measure(name)
    if parsed(name).is_own:
        return
    sizes = {(each.point.curriculum, each.point.task.trials): each.point for each in plan}
    for point in sizes.values():
        stages = [stage.point.task.trials for stage in stages_of(point)]
        try:
            each = found.each(_made_up(stages or [point.task.trials], staged=bool(stages)))
        except ConfigError as error:
            raise ConfigError(f"objective: {error}") from error
        if each is None:
            raise no_mean(name)


def _made_up(trials: Sequence[int], *, staged: bool) -> LearningCurves:
    """Return a result with stages of so many trials, all of one step."""
    one, rows, none = (np.ones(_PERIODS, np.int32), np.ones((_PERIODS, 2), np.int32), np.zeros(_PERIODS, np.int32))
    steps = np.ones((_PERIODS, sum(trials)), np.int32)
    stages = tuple(StageRecord(each, 1.0, one, rows, none) for each in trials) if staged else ()
    return LearningCurves(steps, steps > 0, one, rows, np.zeros(sum(trials)), known_side=1.0, stages=stages)
