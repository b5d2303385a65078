"""A race on the command line: plan it, run it look by look, show its outcome."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import TYPE_CHECKING, Any

from hydra.core.utils import env_override
from omegaconf import DictConfig

from rl_design_space.commands import race_output, sweep_output
from rl_design_space.commands.invocation import current_invocation
from rl_design_space.commands.point_launcher import PointLauncher
from rl_design_space.commands.sweep import plan_sweep, recorded
from rl_design_space.commands.unused_variables import tell_of_unused_variables
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.run.settings import Settings, build_settings

if TYPE_CHECKING:
    from hydra.plugins.launcher import Launcher

    from rl_design_space.analysis.race import Look

#: Fewest periods that differences are known from, and most of a factor between two looks.
_FEWEST, _FURTHEST = 5, 10.0
_SEED, _PERIODS = "seed", "task.periods"


def race(
    arguments: Sequence[str],
    params: Mapping[str, str],
    config: DictConfig,
    launcher: Launcher,
    rules: Mapping[str, Any],
) -> None:
    """Plan a race, and run it unless only its plan is asked for.

    Args:
        arguments: task overrides that Hydra has composed.
        params: sweep overrides of the sweeper's config, by key.
        config: the composed config, with the settings.
        launcher: runs the points.
        rules: first, growth and confidence of the sweeper's config.

    Raises:
        ConfigError: a value is not allowed, or the points cannot be compared.
    """
    invocation = current_invocation()
    typed = invocation.line.overrides if invocation.line else arguments
    with env_override(config.hydra.job.env_set):
        invocation.failed = not _race(typed, params, config, launcher, rules, invocation.command_or())


def _race(
    overrides: Sequence[str],
    params: Mapping[str, str],
    config: DictConfig,
    launcher: Launcher,
    rules: Mapping[str, Any],
    command: str,
) -> bool:
    """Return whether the race has ended without failures, or only its plan is asked for."""
    started = perf_counter()
    settings = build_settings(config)
    tell_of_unused_variables(settings.tracking)
    plan = plan_sweep(overrides, params, config, settings)
    looks = race_looks(plan, settings, launcher, rules)
    if settings.plan:
        begin = Plan([planned.with_periods(looks[0].periods) for planned in plan])
        found = [recorded(part, settings) for part in (begin, plan)]
        race_output.show_plan(plan, begin, looks, settings, found)
        return True
    from rl_design_space.commands.race_run import Race  # which `plan=true` does not need

    assert isinstance(launcher, PointLauncher)
    tracker = settings.tracking.open(command)
    executor = launcher.executor(settings.learning_threads)
    racing = Race(plan, looks, float(rules["confidence"]), settings, tracker, executor, command)
    seconds = {"plan": perf_counter() - started}
    outcome = racing.run()
    outcome.seconds = seconds | outcome.seconds
    chosen = [each for each in overrides if each.startswith(("outputs=", "tracking"))]
    lines = race_output.result_lines(racing.result, outcome.stored, chosen) if racing.result else []
    sweep_output.show_outcome(outcome.findings.plan or plan, outcome, tracker.location, command, lines=lines)
    return not (outcome.failed or outcome.delivery.pending)


def race_looks(plan: Plan, settings: Settings, launcher: Launcher, rules: Mapping[str, Any]) -> tuple[Look, ...]:
    """Return the looks of a race.

    Raises:
        ConfigError: the points cannot be compared, or a rule has a value that is not allowed.
    """
    from rl_design_space.analysis.race import looks
    from rl_design_space.commands.race_objective import check_objective

    if settings.shard:
        part = "/".join(map(str, settings.shard))
        raise ConfigError.at("shard", part, "a race compares all its points; leave it out")
    for planned in plan:
        if (precision := planned.point.task.precision) is not None:
            reason = "a race decides itself how many periods a point gets; leave it out"
            raise ConfigError.at("task.precision", precision, reason)
    if not isinstance(launcher, PointLauncher):
        raise ConfigError("hydra/sweeper=race needs hydra/launcher=design, design_dask or design_ray")
    for name in (_SEED, _PERIODS):
        if values := plan.axes.get(name):
            other = "more task.periods" if name == _SEED else "the largest of them"
            expected = f"a race compares designs over the periods of one seed; ask for {other}"
            raise ConfigError.at(name, ",".join(values), expected)
    if (most := plan[0].point.task.periods) < 2:
        raise ConfigError.at(_PERIODS, most, "a race compares designs over at least 2 periods, better hundreds")
    first, growth, confidence = rules["first"], rules["growth"], rules["confidence"]
    if not isinstance(first, int) or isinstance(first, bool) or first < _FEWEST:
        raise ConfigError.at("hydra.sweeper.first", first, f"should be a whole number of periods, {_FEWEST} or more")
    if not _is_number(growth) or not 1 < growth <= _FURTHEST:
        raise ConfigError.at("hydra.sweeper.growth", growth, f"should be a factor above 1, {_FURTHEST:g} at most")
    if not _is_number(confidence) or not 0.5 <= confidence < 1:
        expected = "should be a probability from 0.5 to below 1, such as 0.95"
        raise ConfigError.at("hydra.sweeper.confidence", confidence, expected)
    check_objective(settings.objective, plan)
    return looks(most, first, float(growth), float(confidence))


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
