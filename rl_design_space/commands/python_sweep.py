"""Sweeps from Python: `rl_design_space.sweep`."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space.commands import sweep_output
from rl_design_space.commands.planning import PlanningProgress
from rl_design_space.commands.progress import Display
from rl_design_space.commands.sweep_best import BestPoints
from rl_design_space.commands.terminal import Terminal, console, counted, outcome_line
from rl_design_space.config import user_config
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.config.grammar import as_override
from rl_design_space.config.overrides import is_setting
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.spelling import Spelling
from rl_design_space.plan.study import load_study
from rl_design_space.run.local_executor import LocalExecutor
from rl_design_space.run.outcome import Outcome
from rl_design_space.run.runner import missing, run_sweep
from rl_design_space.run.settings import Settings, settings_of
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.tracker import Tracker, recorded_as

if TYPE_CHECKING:
    import pandas as pd

#: Settings that choose what to run, and by whom; here, the arguments do.
_OF_THE_COMMAND = r"[+~]*(hydra|study|plan|objective)(?![\w-])"


@dataclass(frozen=True)
class SweepResult:
    """What became of the points of a sweep.

    Attributes:
        plan: the points, each once.
        outcome: how many were learned, and how each ended.
        settings: how they were run and where they are recorded.
        location: the store, for messages.
    """

    plan: Plan
    outcome: Outcome
    settings: Settings
    location: str

    def __repr__(self) -> str:
        return outcome_line(self.plan, self.outcome, self.location)

    @property
    def failed(self) -> dict[str, str]:
        """Why points failed, by the overrides that describe them."""
        names = {planned.fingerprint: planned.name for planned in self.plan}
        return {names[fingerprint]: reason for fingerprint, reason in self.outcome.failed.items()}

    @property
    def scalars(self) -> list[Mapping[str, float] | None]:
        """The scalars of each point, in the order of the plan, see `LearningCurves.scalars`; None if it failed."""
        stored = [self.outcome.stored.get(planned.fingerprint) for planned in self.plan]
        return [run.scalars if run else None for run in stored]

    def runs(self) -> pd.DataFrame:
        """Return the runs of the points, in the order of the plan, as `load_runs` does.

        Raises:
            ConfigError: nothing is recorded, or the store cannot be read.
        """
        from rl_design_space.tracking.load import load_runs

        tracking = self.settings.tracking
        if not isinstance(tracking, MlflowTracking):
            raise ConfigError("tracking=none: nothing is recorded; the numbers of each point are in .scalars")
        recorded = load_runs(uri=tracking.uri, experiment=tracking.experiment, outdated=True)
        stored = self.outcome.stored
        points = [recorded_as(planned, stored.get(planned.fingerprint)) for planned in self.plan]
        places = {point.fingerprint: place for place, point in enumerate(points)}
        mine = recorded[recorded["fingerprint"].isin(list(places))]
        found = mine.iloc[mine["fingerprint"].map(places).argsort(kind="stable")]
        found.attrs.update(recorded.attrs)
        return found


def sweep(
    what: str | Iterable[DesignPoint],
    overrides: Sequence[str] = (),
    *,
    outputs: str | Path = "outputs",
    config_dir: str | Path | None = None,
    progress: bool = True,
) -> SweepResult:
    """Learn and record design points, as `rl-design-space -m` does: each once, those that are recorded not again.

    An interrupted sweep goes on where it was when it is called again. A point that fails does not stop the others.

    Args:
        what: name of a study, or design points.
        overrides: settings as on the command line, `["threads=4", "tracking=none"]`; those of a study may change its
            points as well, `["task.periods=50"]`.
        outputs: folder that all files are written to.
        config_dir: folder with your own options and studies; modules beside it can be imported from then on.
        progress: whether to print progress and the outcome.

    Raises:
        ConfigError: there is no such study, an override or a point is not allowed, or the store cannot be used.
    """
    if isinstance(overrides, str):
        raise ConfigError(f"overrides={overrides}: should be a list, as in sweep(…, [{overrides!r}])")
    for override in overrides:
        if re.match(_OF_THE_COMMAND, override):
            raise ConfigError(f"{override}: for the command line; rl_design_space.sweep takes points or a study's name")
    with user_config.used(config_dir):
        chosen = [as_override("outputs", str(outputs)), *filter(is_setting, overrides)]
        settings = settings_of(chosen)
        with shipped_config():
            planner = Planner(Composer(), PlanningProgress() if progress else lambda number, total: None)
            plan = _plan(what, overrides, planner).named(overrides)
        plan = plan.shard(*settings.shard) if settings.shard else plan
        source = f"rl_design_space.sweep, {counted(len(plan), 'point')}"
        tracker = settings.tracking.open(source)
        outcome = _run(plan, tracker, settings, source, console if progress else Terminal(quiet=True))
        if progress:
            sweep_output.show_outcome(plan, outcome, tracker.location, source, chosen)
    return SweepResult(plan, outcome, settings, tracker.location)


def _plan(what: str | Iterable[DesignPoint], overrides: Sequence[str], planner: Planner) -> Plan:
    if isinstance(what, str):
        if plan := load_study(what, overrides, planner).plan:
            return plan
        raise ConfigError(f"{what}: this study has no design points, only a report")
    for override in overrides:
        if not is_setting(override):
            raise ConfigError(f"{override}: not a setting; change the points themselves, with dataclasses.replace")
    if isinstance(what, DesignPoint) or not isinstance(what, Iterable):
        given = "a DesignPoint" if isinstance(what, DesignPoint) else repr(what)
        raise ConfigError(f"sweep({given}): should be the name of a study or a list of points, as in sweep([point])")
    spell = Spelling(planner.composer)
    points: dict[str, PlannedPoint] = {}
    count = 0
    for point in what:
        if not isinstance(point, DesignPoint):
            raise ConfigError.at(f"point {count + 1}", point, "should be a DesignPoint")
        planned = spell(point)
        points.setdefault(planned.fingerprint, planned)
        count += 1
    if not points:
        raise ConfigError("no design points to learn")
    return Plan(list(points.values()), combinations=count)


def _run(plan: Plan, tracker: Tracker, settings: Settings, source: str, shown: Terminal) -> Outcome:
    found = missing(plan, tracker)
    executor = LocalExecutor(settings.learning_threads)
    with Display(plan, found, executor.describe(), console=shown) as display:
        best = BestPoints(plan, tracker, display)
        return run_sweep(
            plan, tracker, executor, best, command=source, on_error=settings.on_error, found=found,
            findings=best.findings,
        )  # fmt: skip
