"""Sweeps of other sweepers than ours, such as `hydra/sweeper=basic` or `optuna`: run their jobs as points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from hydra.core.utils import JobReturn, JobStatus
from omegaconf import DictConfig, OmegaConf

from rl_design_space.commands.command_line import CommandLine
from rl_design_space.commands.invocation import current_invocation
from rl_design_space.commands.point_launcher import PointLauncher
from rl_design_space.commands.progress import Display
from rl_design_space.commands.sweep_output import show_pending
from rl_design_space.commands.terminal import console, failure_table
from rl_design_space.commands.unused_variables import tell_of_unused_variables
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.config.explain import explained
from rl_design_space.config.overrides import is_search_path, is_setting, shared
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.grid import as_overrides, refuse_empty, refuse_large
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import union
from rl_design_space.run.objective import objective_value, recorded_result
from rl_design_space.run.outcome import Outcome, PointFailedError
from rl_design_space.run.runner import missing, run_sweep
from rl_design_space.run.settings import build_settings
from rl_design_space.tracking.tracker import StoredRun


def launch(job_overrides: Sequence[Sequence[str]], config: DictConfig, launcher: PointLauncher) -> list[JobReturn]:
    """Run jobs of another sweeper as points; each returns its objective.

    Raises:
        ConfigError: a value of a point is not allowed, or a setting differs between jobs.
    """
    # As Hydra's own launchers do: other sweepers write their results there, but do not create the folder.
    Path(config.hydra.sweep.dir).mkdir(parents=True, exist_ok=True)
    invocation = current_invocation()
    settings = build_settings(config)
    if not invocation.jobs:
        tell_of_unused_variables(settings.tracking)
    invocation.jobs += len(job_overrides)
    if len({tuple(filter(is_setting, overrides)) for overrides in job_overrides}) > 1:
        raise ConfigError("a setting differs between jobs; settings apply to the whole sweep")
    refuse_large(len(job_overrides), settings.max_points)
    planner = Planner(Composer.like(config))
    jobs = [planner(overrides) for overrides in job_overrides]
    plan = union([Plan(jobs, combinations=len(jobs))])
    tracker = settings.tracking.open(invocation.command_or())
    found = missing(plan, tracker)
    executor = launcher.executor(settings.learning_threads)
    monitor = _ObjectiveMonitor(Display(plan, found, executor.describe()), settings.objective)
    with monitor.display:
        outcome = run_sweep(plan, tracker, executor, monitor, on_error=settings.on_error, found=found, summarised=False)
    if outcome.failed:
        console.print(failure_table(plan, outcome.failed))
    show_pending(outcome, tracker.location)
    # Of the last batch of jobs only: pending records include those of earlier batches.
    invocation.failed = bool(outcome.delivery.pending)
    points = {planned.fingerprint: planned.point for planned in plan}
    for fingerprint, run in outcome.stored.items():
        if fingerprint not in monitor.objectives:
            result = partial(recorded_result, settings.objective, settings.tracking, run, points[fingerprint])
            monitor.objectives[fingerprint] = objective_value(settings.objective, run.scalars, result)
    return [_job_return(planned, monitor.objectives, outcome) for planned in jobs]


def refuse_empty_sweep(line: CommandLine) -> None:
    """Raise an error if an override of a sweep matches nothing: other sweepers run no job then, and report success.

    Args:
        line: the command line.

    Raises:
        ConfigError: an override matches nothing.
    """
    with shipped_config():
        places = [override for override in line.overrides if is_search_path(override)]
        composer = Composer(places)
        with explained():
            parsed = composer.parser.parse_overrides(list(line.overrides))
        sweeper: Any = OmegaConf.to_container(composer.config(shared(parsed)).hydra.sweeper)
        refuse_empty([*as_overrides(sweeper.get("params") or {}), *line.overrides], composer.parser)


class _ObjectiveMonitor:
    """Keeps the objectives of the points, and passes all events on to a display."""

    def __init__(self, display: Display, objective: str) -> None:
        self.display = display
        #: By fingerprint.
        self.objectives: dict[str, float] = {}
        self._objective = objective

    def point_started(self, planned: PlannedPoint) -> None:
        self.display.point_started(planned)

    def point_learned(self, planned: PlannedPoint) -> None:
        self.display.point_learned(planned)

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        if isinstance(result, LearningCurves):
            self.objectives[planned.fingerprint] = objective_value(self._objective, result.scalars(), lambda: result)
        self.display.point_ended(planned, result)

    def waiting(self, points: int) -> None:
        self.display.waiting(points)

    def delivering(self, pending: int, problem: str) -> None:
        self.display.delivering(pending, problem)


def _job_return(planned: PlannedPoint, objectives: Mapping[str, float], outcome: Outcome) -> JobReturn:
    """Return the result of a job without its composed config, which would stay in memory."""
    done = JobReturn(overrides=planned.overrides)
    if planned.fingerprint in objectives:
        done.status, done.return_value = JobStatus.COMPLETED, objectives[planned.fingerprint]
    else:
        reason = outcome.failed.get(planned.fingerprint, "not run, because another point failed")
        done.status, done.return_value = JobStatus.FAILED, PointFailedError(f"{planned.name}: {reason}")
    return done
