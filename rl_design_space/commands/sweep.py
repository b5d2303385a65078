"""A sweep on the command line: plan it, run it, show its outcome."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from hydra.core.utils import env_override
from omegaconf import DictConfig, OmegaConf

from rl_design_space.commands import sweep_output
from rl_design_space.commands.invocation import current_invocation
from rl_design_space.commands.planning import PlanningProgress
from rl_design_space.commands.point_launcher import PointLauncher
from rl_design_space.commands.sweep_best import BestPoints
from rl_design_space.commands.unused_variables import tell_of_unused_variables
from rl_design_space.config.compose import Composer
from rl_design_space.config.overrides import is_setting
from rl_design_space.errors import ConfigError
from rl_design_space.plan.grid import as_overrides, axes
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import load_study, plan_overrides, union
from rl_design_space.run.dumps import write_dumps
from rl_design_space.run.outcome import Outcome, describe_error, summary_run
from rl_design_space.run.runner import Missing, add_studies, missing, run_sweep
from rl_design_space.run.settings import Settings, build_settings
from rl_design_space.tracking.tracker import Tracker

if TYPE_CHECKING:
    from hydra.plugins.launcher import Launcher


def sweep(arguments: Sequence[str], params: Mapping[str, str], config: DictConfig, launcher: Launcher) -> None:
    """Plan a sweep, and run it unless only its plan is asked for.

    Args:
        arguments: task overrides that Hydra has composed.
        params: sweep overrides of the sweeper's config, by key.
        config: the composed config, with the settings.
        launcher: runs the points.

    Raises:
        ConfigError: a value of a point is not allowed, or the sweep has no point.
    """
    invocation = current_invocation()
    # Hydra gets the overrides of the command line as they apply to the whole sweep.
    typed = invocation.line.overrides if invocation.line else arguments
    with env_override(config.hydra.job.env_set):
        invocation.failed = not _sweep(typed, params, config, launcher, invocation.command_or())


def _sweep(
    overrides: Sequence[str], params: Mapping[str, str], config: DictConfig, launcher: Launcher, command: str
) -> bool:
    """Return whether all points are recorded, or only their plan is asked for."""
    started = perf_counter()
    settings = build_settings(config)
    tell_of_unused_variables(settings.tracking)
    if not isinstance(params, Mapping):
        raise ConfigError.at("hydra.sweeper.params", params, "should be a mapping of keys to sweeps")
    plan = plan_sweep(overrides, params, config, settings)
    seconds = {"plan": perf_counter() - started}
    if settings.plan:
        line = current_invocation().line
        only_planned = line is not None and line.only_planned
        sweep_output.show_plan(plan, settings, recorded(plan, settings), only_planned=only_planned)
        return True
    tracker = settings.tracking.open(command)
    found = missing(plan, tracker)
    outcome = _run(plan, found, tracker, settings, launcher, command)
    outcome.seconds = seconds | outcome.seconds
    chosen = [each for each in overrides if each.startswith(("outputs=", "tracking"))]
    sweep_output.show_outcome(plan, outcome, tracker.location, command, chosen)
    return not (outcome.failed or outcome.delivery.pending)


def plan_sweep(overrides: Sequence[str], params: Mapping[str, str], config: DictConfig, settings: Settings) -> Plan:
    """Plan a sweep.

    Args:
        overrides: of the command line.
        params: sweep overrides of the sweeper's config, by key.
        config: the composed config, with the settings.
        settings: the same settings, built.

    Raises:
        ConfigError: a value of a point is not allowed, a setting differs between points, or the sweep has no point.
    """
    planner = Planner(Composer.like(config), PlanningProgress())
    overrides = [*as_overrides(params), *overrides]
    names = _studies(overrides, config, planner)
    overrides = [override for override in overrides if not override.startswith("study=")]
    _refuse_settings(params)
    for key, values in axes(
        [override for override in overrides if is_setting(override)], planner.composer.parser
    ).items():
        if len(values) > 1:
            raise ConfigError(f"{key}: a setting applies to the whole sweep; give it one value")
    if names:
        plan = union([load_study(name, overrides, planner).plan for name in names])
        if not plan:
            raise ConfigError(
                f"study={','.join(names)}: no design points, only a report; run rl-design-report {names[0]}"
            )
    else:
        plan = plan_overrides(overrides, planner, settings.max_points)
    plan = plan.named(overrides)
    return plan.shard(*settings.shard) if settings.shard else plan


def _studies(overrides: Sequence[str], config: DictConfig, planner: Planner) -> list[str]:
    """Return the names of the studies that an override, or else a file, chooses."""
    chosen = axes([override for override in overrides if override.startswith("study=")], planner.composer.parser)
    if chosen:
        names = [override.removeprefix("study=") for values in chosen.values() for override in values]
        return [] if names == ["null"] else names
    name = config.hydra.runtime.choices.get("study")
    if not name and OmegaConf.select(config, "study") is not None:
        raise ConfigError("study: has no name; write it to study/NAME.yaml in a config folder, and choose study=NAME")
    return [name] if name else []


def _refuse_settings(params: Mapping[str, str]) -> None:
    for key, value in params.items():
        if key != "study" and is_setting(f"{key}="):
            expected = "a setting applies to the whole sweep; write it beside hydra, not among its params"
            raise ConfigError.at(f"hydra.sweeper.params.{key}", value, expected)


def recorded(plan: Plan, settings: Settings) -> sweep_output.Recorded:
    """Return which points are recorded; no store is created."""
    try:
        reader = settings.tracking.reader()
    except ConfigError:
        return sweep_output.Recorded()
    stored = reader.finished([planned.fingerprint for planned in plan])
    left = [planned for planned in plan if planned.fingerprint not in stored]
    if not left:
        return sweep_output.Recorded(stored)
    from rl_design_space.tracking.selection import changed_since  # which a sweep that runs does not need

    begun = {fingerprint: beginning.periods for fingerprint, beginning in reader.beginnings(left).items()}
    return sweep_output.Recorded(stored, begun, changed_since(left, reader.runs()))


def _run(plan: Plan, found: Missing, tracker: Tracker, settings: Settings, launcher: Launcher, command: str) -> Outcome:
    from rl_design_space.commands.progress import Display  # which `plan=true` does not need

    if not isinstance(launcher, PointLauncher):
        return _run_as_jobs(plan, found, tracker, launcher, command)
    if launcher.dumps:
        write_dumps(found.points, Path(settings.outputs) / "points")
    executor = launcher.executor(settings.learning_threads)
    with Display(plan, found, executor.describe()) as display:
        best = BestPoints(plan, tracker, display)
        return run_sweep(
            plan, tracker, executor, best, command=command, on_error=settings.on_error, found=found,
            findings=best.findings,
        )  # fmt: skip


def _run_as_jobs(plan: Plan, found: Missing, tracker: Tracker, launcher: Launcher, command: str) -> Outcome:
    """Run the missing points with a launcher of Hydra's; each job composes, learns and records its own point."""
    outcome = Outcome(len(plan), already=len(found.stored), stored=dict(found.stored))
    add_studies(plan, found.stored, tracker)
    if found.points:
        with summary_run(plan, outcome, tracker, command):
            jobs = launcher.launch([planned.overrides for planned in found.points], initial_job_idx=0)
            for planned, job in zip(found.points, jobs, strict=True):
                try:
                    _ = job.return_value  # raises the error of a failed job
                    outcome.done += 1
                except Exception as error:
                    outcome.failed[planned.fingerprint] = describe_error(error)
            outcome.stored |= tracker.finished([planned.fingerprint for planned in found.points])
            add_studies(plan, outcome.stored, tracker)
    outcome.delivery = tracker.wait_for_delivery()
    return outcome
