"""Studies: named unions of grids of design points."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from omegaconf import DictConfig

from rl_design_space.config import user_config
from rl_design_space.config.build import build, plain
from rl_design_space.config.overrides import is_setting, is_sweep_setting
from rl_design_space.design import Task
from rl_design_space.errors import ConfigError
from rl_design_space.plan.constraint import Constraint, constraints_of
from rl_design_space.plan.grid import as_overrides, axes, expand
from rl_design_space.plan.plan import Dropped, Plan, PlannedPoint
from rl_design_space.plan.planner import Planner

#: Periods of a point unless a study says otherwise.
_PERIODS = Task().periods


@dataclass(frozen=True)
class Study:
    """A study with the overrides of one command.

    Attributes:
        name: name of its file in conf/study.
        overrides: overrides of the command line, without `study=…`.
        config: the composed config, with the settings.
        plan: its design points, without duplicates.
        usual_periods: the most periods of a point without the overrides.
    """

    name: str
    overrides: tuple[str, ...]
    config: DictConfig
    plan: Plan
    usual_periods: int = _PERIODS

    @property
    def command(self) -> str:
        """The command that runs the study."""
        return shlex.join(["rl-design-space", *user_config.flags(), f"study={self.name}", *self.overrides])

    @property
    def report_command(self) -> str:
        """The command that writes its report."""
        return shlex.join(["rl-design-report", *user_config.flags(), self.name, *self.overrides])

    @property
    def mark(self) -> str:
        """A note for figures whose points have fewer periods than the study's file asks for; empty otherwise."""
        most, usual = _most_periods(self.plan), self.usual_periods
        return f"quick look: {most} periods instead of {usual}" if most < usual else ""

    def report(self) -> Any:
        """Build the report that the study's file describes.

        Raises:
            ConfigError: the file describes no report, or a value is not allowed.
        """
        node = plain(self.config, "study").get("report")
        if node is None:
            raise ConfigError(
                f"study {self.name}: its file describes no report; add one (docs/reports.md), or plot its "
                f"runs, e.g. rl-design-report curves --by representation --study {self.name}"
            )
        return build("study.report", node)


def load_study(name: str, overrides: Sequence[str], planner: Planner | None = None) -> Study:
    """Compose and plan a study.

    Args:
        name: of the study.
        overrides: overrides of the command line; they replace those of a block for the same key.
        planner: plans the points; a new one if None.

    Raises:
        ConfigError: there is no such study, an override cannot be parsed, or a value is not allowed.
    """
    planner = planner or Planner()
    overrides = tuple(override for override in overrides if not override.startswith("study="))
    config = planner.composer.config([f"study={name}", *filter(is_setting, overrides)])
    node = plain(config, "study")
    if isinstance(node, Mapping) and "includes" in node:
        studies = _included(name, node["includes"], overrides, planner)
        usual = max((each.usual_periods for each in studies if each.plan), default=_PERIODS)
        return Study(name, overrides, config, _joined(name, studies), usual)
    plan = plan_study(name, config, overrides, planner)
    changed = plan and not all(map(is_setting, overrides))
    return Study(name, overrides, config, plan, _usual_periods(config, planner) if changed else _most_periods(plan))


def _most_periods(plan: Plan) -> int:
    return max((planned.point.task.periods for planned in plan), default=_PERIODS)


def _usual_periods(config: DictConfig, planner: Planner) -> int:
    """Return the most periods of a point as the blocks of a study ask for them."""
    blocks = [
        axes(as_overrides(sweeps), planner.composer.parser) for sweeps in plain(config, "study")["blocks"].values()
    ]
    asked = [value for block in blocks for value in block.get("task.periods", ())]
    periods = [int(value.partition("=")[2]) for value in asked]
    if not all("task.periods" in block for block in blocks):
        periods.append(int(plain(config, "task")["periods"]))
    return max(periods)


def plan_study(name: str, config: DictConfig, overrides: Sequence[str], planner: Planner) -> Plan:
    """Return the points of a study, in the order of its blocks, without duplicates.

    Args:
        name: of the study.
        config: composed config whose `study.blocks` hold the sweeps of each block, by key: all combinations of a
            block are points, except those that `study.constraints` drop. Alternatively, `study.includes` names other
            studies, whose points are this one's.
        overrides: overrides of the command line.
        planner: plans the points.

    Raises:
        ConfigError: an override cannot be parsed, a value is not allowed, or the study has neither points nor a report.
    """
    node = plain(config, "study")
    blocks = node.get("blocks") if isinstance(node, Mapping) else None
    if isinstance(node, Mapping) and "includes" in node:
        return _joined(name, _included(name, node["includes"], overrides, planner))
    if blocks is None and isinstance(node, Mapping) and "report" in node:
        return Plan([], (name,))  # a report that needs no points
    if not isinstance(blocks, Mapping) or not all(isinstance(sweeps, Mapping) for sweeps in blocks.values()):
        raise ConfigError(f"study {name}: needs blocks, each a mapping of keys to sweeps")
    grids = _Grids(name, planner)
    try:
        constraints = constraints_of(node.get("constraints"))
    except ConfigError as error:
        raise ConfigError(f"study {name}, {error}") from error
    of_points = [override for override in overrides if not is_sweep_setting(override)]
    for block, sweeps in blocks.items():
        try:
            grids.add(expand([*as_overrides(sweeps), *of_points], planner.composer.parser), constraints)
        except ConfigError as error:
            raise ConfigError(f"study {name}, block {block}: {error}") from error
    plan = grids.plan()
    if not plan:
        left_out = f" and its constraints drop all {plan.combinations} combinations" if plan.combinations else ""
        raise ConfigError(f"study {name}: no design points; its blocks are {', '.join(blocks) or 'none'}{left_out}")
    return plan


def _included(name: str, included: Any, overrides: Sequence[str], planner: Planner) -> list[Study]:
    """Return the studies that a study includes."""
    if not isinstance(included, list) or not all(isinstance(other, str) and other != name for other in included):
        raise ConfigError(f"study {name}: includes should be a list of the names of other studies")
    return [load_study(other, overrides, planner) for other in included]


def _joined(name: str, studies: Sequence[Study]) -> Plan:
    """Return the points of studies, which also belong to the one that includes them."""
    both = union([study.plan for study in studies])
    return replace(both, points=[replace(p, studies=(name, *p.studies)) for p in both], studies=(name, *both.studies))


def plan_overrides(overrides: Sequence[str], planner: Planner) -> Plan:
    """Return the points of a grid of sweep overrides, without duplicates.

    Raises:
        ConfigError: an override cannot be parsed, or a value is not allowed.
    """
    grids = _Grids("", planner)
    of_points = [override for override in overrides if not is_sweep_setting(override)]
    grids.add(expand(of_points, planner.composer.parser), {})
    return grids.plan()


def union(plans: Sequence[Plan]) -> Plan:
    """Return the points of several plans without duplicates; a common point belongs to the studies of all of them."""
    points: dict[str, PlannedPoint] = {}
    for plan in plans:
        for planned in plan:
            known = points.get(planned.fingerprint)
            studies = tuple(dict.fromkeys((*known.studies, *planned.studies))) if known else planned.studies
            points[planned.fingerprint] = replace(known or planned, studies=studies)
    return Plan(
        list(points.values()),
        studies=tuple(dict.fromkeys(name for plan in plans for name in plan.studies)),
        combinations=sum(plan.combinations for plan in plans),
        dropped=tuple(dropped for plan in plans for dropped in plan.dropped),
    )


class _Grids:
    """Collects the points of grids."""

    def __init__(self, study: str, planner: Planner) -> None:
        self._studies = (study,) if study else ()
        self._planner = planner
        self._points: dict[str, PlannedPoint] = {}
        self._combinations = 0
        self._dropped: Counter[tuple[str, str]] = Counter()

    def add(self, grid: Iterable[tuple[str, ...]], constraints: Mapping[str, Constraint]) -> None:
        for overrides in grid:
            self._combinations += 1
            parts = self._planner.composer.parts(overrides)
            for name, constraint in constraints.items():
                try:
                    drops = constraint.drops(parts)
                except ConfigError as error:
                    raise ConfigError(f"constraint {name}: {error}") from error
                if drops:
                    self._dropped[name, constraint.why] += 1
                    break
            else:
                planned = self._planner.of_parts(parts, overrides, self._studies)
                self._points.setdefault(planned.fingerprint, planned)

    def plan(self) -> Plan:
        study = "".join(self._studies)
        dropped = tuple(Dropped(study, name, why, count) for (name, why), count in self._dropped.items())
        return Plan(list(self._points.values()), self._studies, self._combinations, dropped)
