"""What a sweep on the command line does, from its overrides to its exit status."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from hydra.core.utils import JobReturn, JobStatus
from omegaconf import DictConfig

from rl_design_space.commands.invocation import current_invocation
from rl_design_space.config.compose import Composer
from rl_design_space.config.overrides import is_setting
from rl_design_space.errors import ConfigError
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_seconds
from rl_design_space.plan.grid import axes
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import load_study, plan_overrides, union
from rl_design_space.run.dumps import write_dumps
from rl_design_space.run.executor import PointLauncher
from rl_design_space.run.objective import objective_value
from rl_design_space.run.runner import Missing, Outcome, add_studies, describe_error, missing, run_sweep, summary
from rl_design_space.run.settings import Settings, build_settings
from rl_design_space.tracking.tracker import StoredRun, Tracker

if TYPE_CHECKING:
    from hydra.plugins.launcher import Launcher


#: Recorded as the source of runs where no command line is known.
_COMMAND = "rl-design-space"


def sweep(arguments: Sequence[str], params: Mapping[str, str], config: DictConfig, launcher: Launcher) -> None:
    """Plan a sweep, and run it unless only the plan is asked for.

    Args:
        arguments: task overrides that Hydra composed.
        params: of the sweeper's config.
        config: the composed config, with the settings.
        launcher: who runs the points.

    Raises:
        ConfigError: a value of a point is not allowed, or there is no point.
    """
    invocation = current_invocation()
    line = invocation.line
    started = perf_counter()
    settings = build_settings(config)
    overrides = [*(f"{key}={value}" for key, value in params.items()), *(line.for_points if line else ()), *arguments]
    plan = _plan(overrides, config, settings)
    seconds = {"plan": perf_counter() - started}
    command = invocation.command_or(_COMMAND)
    if settings.plan:
        _show_plan(plan, settings)
        return
    tracker = settings.tracking.open(command)
    found = missing(plan, tracker)
    outcome = _run(plan, found, tracker, settings, launcher, command)
    outcome.seconds = seconds | outcome.seconds
    _close(plan, outcome, tracker, command)


def launch(job_overrides: Sequence[Sequence[str]], config: DictConfig, launcher: PointLauncher) -> list[JobReturn]:
    """Run the points that another sweeper asks for; each returns its objective.

    Raises:
        ConfigError: a value of a point is not allowed, or a setting differs from job to job.
    """
    from rl_design_space.commands.progress import Display
    from rl_design_space.commands.terminal import console, failure_table, pending_line

    invocation = current_invocation()
    invocation.jobs += len(job_overrides)
    settings = build_settings(config)
    if len({tuple(filter(is_setting, overrides)) for overrides in job_overrides}) > 1:
        raise ConfigError("a setting differs from job to job; settings hold for a whole sweep")
    planner = Planner(Composer(_searchpath(config)))
    jobs = [planner(overrides) for overrides in job_overrides]
    plan = union([Plan(jobs, combinations=len(jobs))])
    tracker = settings.tracking.open(invocation.command_or(_COMMAND))
    found = missing(plan, tracker)
    executor = launcher.executor(_threads(settings))
    objectives = _Objectives(Display(plan, found, executor.describe()), settings.objective)
    with objectives.display:
        outcome = run_sweep(
            plan, tracker, executor, objectives, on_error=settings.on_error, found=found, summarised=False
        )
    if outcome.failed:
        console.print(failure_table(plan, outcome.failed))
    # The records of earlier jobs are awaited as well.
    invocation.undelivered = bool(outcome.delivery.pending)
    if invocation.undelivered:
        console.print(pending_line(outcome.delivery, tracker), markup=False, soft_wrap=True)
    for fingerprint, run in outcome.stored.items():
        objectives.values.setdefault(fingerprint, objective_value(settings.objective, run.scalars))
    return [_job_return(planned, objectives.values, outcome) for planned in jobs]


class _Objectives:
    """Remembers the objectives of points while they are shown."""

    def __init__(self, display: Any, objective: str) -> None:
        self.display = display
        self.values: dict[str, float] = {}
        self._objective = objective

    def started(self, planned: PlannedPoint) -> None:
        self.display.started(planned)

    def learned(self, planned: PlannedPoint) -> None:
        self.display.learned(planned)

    def ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        if isinstance(result, LearningCurves):
            scalars = result.scalars()
            self.values[planned.fingerprint] = objective_value(self._objective, scalars)
        self.display.ended(planned, result)

    def waiting(self, left: int, trouble: str) -> None:
        self.display.waiting(left, trouble)


def _job_return(planned: PlannedPoint, objectives: Mapping[str, float], outcome: Outcome) -> JobReturn:
    """What Hydra's sweepers get; the composed configs are left out, which would fill the memory."""
    done = JobReturn(overrides=planned.overrides)
    if planned.fingerprint in objectives:
        done.status, done.return_value = JobStatus.COMPLETED, objectives[planned.fingerprint]
    else:
        reason = outcome.failed.get(planned.fingerprint, "not run, because another point failed")
        done.status, done.return_value = JobStatus.FAILED, RuntimeError(f"{planned.name}: {reason}")
    return done


def _plan(overrides: Sequence[str], config: DictConfig, settings: Settings) -> Plan:
    planner = Planner(Composer(_searchpath(config)))
    parser = planner.composer.parser
    studies = axes([override for override in overrides if override.startswith("study=")], parser)
    names = [override.removeprefix("study=") for values in studies.values() for override in values]
    overrides = [override for override in overrides if not override.startswith("study=")]
    for key, values in axes([override for override in overrides if is_setting(override)], parser).items():
        if len(values) > 1:
            raise ConfigError(f"{key}: a setting holds for a whole sweep; give it one value")
    if names and names != ["null"]:
        plan = union([load_study(name, overrides, planner).plan for name in names])
    else:
        plan = plan_overrides(overrides, planner)
    if not plan:
        raise ConfigError("no design point in this sweep")
    return plan.shard(*settings.shard) if settings.shard else plan


def _searchpath(config: DictConfig) -> list[str]:
    """Where Hydra was told to look for options as well."""
    return [override for override in config.hydra.overrides.hydra if "hydra.searchpath=" in override]


def _threads(settings: Settings) -> int:
    return settings.threads or available_threads()


def _show_plan(plan: Plan, settings: Settings) -> None:
    from rl_design_space.commands.terminal import console, duration, plan_lines, plan_table

    stored = _stored(plan, settings)
    left = [planned.point for planned in plan if planned.fingerprint not in stored]
    threads = _threads(settings)
    if plan.axes:
        console.print(plan_table(plan))
    for line in plan_lines(plan):
        console.print(line, markup=False, soft_wrap=True)
    if settings.shard:
        console.print(f"part {settings.shard[0]} of {settings.shard[1]}: {len(plan):,} points")
    seconds = duration(expected_seconds(left, threads))
    console.print(f"{len(stored):,} recorded already, {len(left):,} to run: about {seconds} on {threads} cores")
    console.print("nothing was run; the same without plan=true runs them", markup=False)


def _stored(plan: Plan, settings: Settings) -> Mapping[str, StoredRun]:
    """The points of a plan that are recorded, without making a store where there is none."""
    try:
        reader = settings.tracking.reader()
    except ConfigError:
        return {}
    return reader.finished([planned.fingerprint for planned in plan])


def _run(plan: Plan, found: Missing, tracker: Tracker, settings: Settings, launcher: Launcher, command: str) -> Outcome:
    from rl_design_space.commands.progress import Display

    if not isinstance(launcher, PointLauncher):
        return _run_as_jobs(plan, found, tracker, launcher, command)
    if launcher.dumps:
        write_dumps(found.points, Path(settings.outputs) / "points")
    executor = launcher.executor(_threads(settings))
    with Display(plan, found, executor.describe()) as display:
        return run_sweep(plan, tracker, executor, display, command=command, on_error=settings.on_error, found=found)


def _run_as_jobs(plan: Plan, found: Missing, tracker: Tracker, launcher: Launcher, command: str) -> Outcome:
    """Have a launcher of Hydra's run the missing points; each job composes, learns and records its own."""
    outcome = Outcome(len(plan), already=len(found.stored), stored=dict(found.stored))
    add_studies(plan, found.stored, tracker)
    if found.points:
        with summary(plan, outcome, tracker, command):
            jobs = launcher.launch([planned.overrides for planned in found.points], initial_job_idx=0)
            for planned, job in zip(found.points, jobs, strict=True):
                try:
                    _ = job.return_value
                    outcome.done += 1
                except Exception as error:
                    outcome.failed[planned.fingerprint] = describe_error(error)
            outcome.stored |= tracker.finished([planned.fingerprint for planned in found.points])
            add_studies(plan, outcome.stored, tracker)
    outcome.delivery = tracker.wait_for_delivery()
    return outcome


def _close(plan: Plan, outcome: Outcome, tracker: Tracker, command: str) -> None:
    """Say what became of a sweep; its exit status is 1 if a point failed, or the store does not have all."""
    from rl_design_space.commands.terminal import console, failure_table, outcome_line, pending_line

    console.print(outcome_line(plan, outcome, tracker.location), markup=False, soft_wrap=True)
    if outcome.failed:
        console.print(failure_table(plan, outcome.failed))
        if outcome.counts["left"]:
            console.print(f"stopped at the first failure; this goes on: {command}", markup=False, soft_wrap=True)
    if outcome.delivery.pending:
        console.print(pending_line(outcome.delivery, tracker), markup=False, soft_wrap=True)
    if outcome.failed or outcome.delivery.pending:
        sys.exit(1)
