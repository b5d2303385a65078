"""Results from elsewhere: `rl_design_space.record`."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rl_design_space.commands.progress import Display
from rl_design_space.commands.terminal import Terminal
from rl_design_space.config import user_config
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.config.grammar import as_override
from rl_design_space.config.overrides import is_setting
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.optimum import luckiest_tours, optimal_steps
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.tables import learning_tables
from rl_design_space.plan.external import ExternalPoint
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.spelling import Spelling
from rl_design_space.run.executor import PointResult
from rl_design_space.run.runner import missing, run_sweep
from rl_design_space.run.settings import settings_of
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.tracker import StoredRun

#: Seconds between two looks at a point that another process is recording.
_POLL = 0.2


def record(
    point: DesignPoint,
    curves: LearningCurves | Mapping[str, ArrayLike],
    *,
    learner: str,
    choices: Mapping[str, Any] = MappingProxyType({}),
    studies: Sequence[str] = (),
    seconds: float = math.nan,
    overrides: Sequence[str] = (),
    outputs: str | Path = "outputs",
    config_dir: str | Path | None = None,
) -> str:
    """Record what a learner of your own has measured, beside the runs of this package and as they are, exactly once.

    The starts and goals are those of the point: `rl_design_space.environment` has them, period by period. Its learner
    and exploration do not count, because yours were others; the run is marked as external.

    Args:
        point: the task that was learned.
        curves: `steps` and `success`, both (periods, trials): the steps of each trial, and whether it reached the final
            goal. A trial that did not has `task.max_steps` steps.
        learner: name of your learner, as in reports: `my_dqn`.
        choices: what is to be known of it: `{"learner.hidden": 64, "exploration": "linear"}`. Other choices are other
            runs.
        studies: names of studies that the run belongs to.
        seconds: wall time of learning, if it is known.
        overrides: settings as on the command line, `["tracking=server", "tracking.uri=…"]`.
        outputs: folder that all files are written to.
        config_dir: folder with your own options; modules beside it can be imported from then on.

    Returns:
        The id of the run; empty while the store cannot be reached: then the result is safe on disk, and
        `rl-design-space sync` delivers it.

    Raises:
        ConfigError: the curves are not possible on the layouts of the point, another result is recorded under the same
            name and choices, or an argument is not allowed.
    """
    if not isinstance(point, DesignPoint):
        raise ConfigError.at("point", point, "should be a DesignPoint")
    if point.task.precision is not None:
        raise ConfigError.at("task.precision", point.task.precision, "should be None: the curves say how many periods")
    for override in overrides:
        if not is_setting(override):
            raise ConfigError(f"{override}: not a setting; change the point itself, with dataclasses.replace")
    with user_config.used(config_dir):
        settings = settings_of([as_override("outputs", str(outputs)), *overrides])
        if not isinstance(settings.tracking, MlflowTracking):
            raise ConfigError("tracking=none: nothing would be recorded")
        planned = _planned(point, learner, choices, tuple(studies))
        measured = _measured(point, curves, seconds)
        tracker = settings.tracking.open("rl_design_space.record")
        plan = Plan([planned])
        found = missing(plan, tracker)
        with Display(plan, found, "", console=Terminal(quiet=True)) as display:
            outcome = run_sweep(plan, tracker, _Measured(measured), display, found=found, summarised=False)
        for reason in outcome.failed.values():
            raise ConfigError(reason)
        if outcome.delivery.pending:
            warnings.warn(f"not yet in {tracker.location}, safe on disk: {outcome.delivery.reason}", stacklevel=2)
            return ""
        stored = tracker.finished([planned.fingerprint])[planned.fingerprint]
        if not outcome.done:
            _check_same(settings.tracking, stored, measured, planned)
        return stored.run_id


@dataclass(frozen=True)
class _Measured:
    """An executor that learns nothing: the result is there."""

    result: LearningCurves

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[PointResult, None, None]:
        for planned in points:
            if planned is None:
                time.sleep(_POLL)
            else:
                yield planned, self.result

    def describe(self) -> str:
        return "measured elsewhere"


def _planned(point: DesignPoint, learner: str, choices: Mapping[str, Any], studies: tuple[str, ...]) -> PlannedPoint:
    with shipped_config():
        composer = Composer()
        if not isinstance(learner, str) or not learner:
            raise ConfigError.at("learner", learner, "should be the name of your learner")
        if learner in composer.options("learner"):
            raise ConfigError(f"learner={learner}: a learner of this package; give yours another name")
        return ExternalPoint.of_planned(Spelling(composer)(point, studies), learner, choices)


def _measured(point: DesignPoint, curves: LearningCurves | Mapping[str, ArrayLike], seconds: float) -> LearningCurves:
    """Return curves that are possible on the layouts of a point.

    Raises:
        ConfigError: they are not.
    """
    if isinstance(curves, LearningCurves):
        curves = {"steps": curves.steps, "success": curves.success}
    if set(curves) != {"steps", "success"}:
        raise ConfigError(f"curves: {', '.join(map(str, curves)) or 'empty'}: should be steps and success")
    task = point.task
    steps, success = (np.asarray(curves[name]) for name in ("steps", "success"))
    for name, array, kinds in (("steps", steps, "iu"), ("success", success, "b")):
        if array.shape != (task.periods, task.trials):
            expected = f"should be {task.periods} × {task.trials}, periods × trials of the point"
            raise ConfigError(f"curves: {name} is {' × '.join(map(str, array.shape))}: {expected}")
        if array.dtype.kind not in kinds:
            kind = "whole numbers" if name == "steps" else "True or False"
            raise ConfigError(f"curves: {name} is of type {array.dtype}: should be {kind}")
    tables, layouts = learning_tables(point), layouts_of(point)
    optimum = optimal_steps(tables, layouts)
    least = np.where(success, luckiest_tours(tables, layouts)[:, np.newaxis], task.max_steps)
    _refuse(steps, steps > task.max_steps, f"are more than task.max_steps={task.max_steps}")
    _refuse(steps, ~success & (steps < least), f"without success: should be task.max_steps={task.max_steps}")
    _refuse(steps, success & (steps < least), "are fewer than the start and goals of this period need at least")
    rows = np.full((task.periods, 2), -1, np.int32)  # not known
    epsilon = np.full(task.trials, np.nan)
    return LearningCurves(steps.astype(np.int32), success, optimum, rows, epsilon, seconds, point)


def _refuse(steps: NDArray[Any], wrong: NDArray[np.bool_], reason: str) -> None:
    if wrong.any():
        period, trial = np.argwhere(wrong)[0]
        raise ConfigError(f"curves: period {period}, trial {trial}: {steps[period, trial]} steps {reason}")


def _check_same(tracking: MlflowTracking, stored: StoredRun, measured: LearningCurves, planned: PlannedPoint) -> None:
    """Refuse a result that differs from the recorded one.

    Raises:
        ConfigError: it does.
    """
    recorded = tracking.reader().periods(stored)
    if "steps" in recorded and not (
        np.array_equal(recorded["steps"], measured.steps) and np.array_equal(recorded["success"], measured.success)
    ):
        raise ConfigError(
            f"{planned.name}: recorded already, with another result (run {stored.run_id}); name what differs among the "
            "choices, or give this learner another name"
        )
