"""Studies: named unions of grids of design points."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from omegaconf import DictConfig

from rl_design_space._paths import leads_out
from rl_design_space.config import user_config
from rl_design_space.config.build import build, plain
from rl_design_space.config.explain import explained
from rl_design_space.config.grammar import parse
from rl_design_space.config.measure_name import with_own_measures
from rl_design_space.config.overrides import is_setting, shared
from rl_design_space.design import Task
from rl_design_space.errors import ConfigError
from rl_design_space.plan.block import block_overrides
from rl_design_space.plan.constraint import Constraint, constraints_of
from rl_design_space.plan.grid import MAX_POINTS, Grid, axes, refuse_large
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
        return build("study.report", with_own_measures(node))


def load_study(
    name: str, overrides: Sequence[str], planner: Planner | None = None, included_by: tuple[str, ...] = ()
) -> Study:
    """Compose and plan a study.

    Args:
        name: of the study.
        overrides: overrides of the command line; they replace those of a block for the same key.
        planner: plans the points; a new one if None.
        included_by: names of the studies that include it, from the outermost on.

    Raises:
        ConfigError: there is no such study, an override cannot be parsed, or a value is not allowed.
    """
    if leads_out(name):
        raise ConfigError.at("study", name, "should be the name of a study: the files of its report are named after it")
    planner = planner or Planner()
    overrides = tuple(override for override in overrides if not override.startswith("study="))
    composer = planner.composer
    with explained():
        parsed = parse(overrides, composer.parser)
    config = composer.config([f"study={name}", *shared(parsed)])
    node = plain(config, "study")
    if isinstance(node, Mapping) and "includes" in node:
        studies = _included((*included_by, name), node["includes"], overrides, planner)
        usual = max((each.usual_periods for each in studies if each.plan), default=_PERIODS)
        return Study(name, overrides, config, _joined(name, studies), usual)
    plan = plan_study(name, config, overrides, planner)
    changed = plan and not all(map(is_setting, overrides))
    return Study(name, overrides, config, plan, _usual_periods(config, planner) if changed else _most_periods(plan))


def _most_periods(plan: Plan) -> int:
    return max((planned.point.task.periods for planned in plan), default=_PERIODS)


def _usual_periods(config: DictConfig, planner: Planner) -> int:
    """Return the most periods of a point as the blocks of a study ask for them."""
    composer, sweeps = planner.composer, plain(config, "study")["blocks"].values()
    blocks = [axes(block_overrides(block, (), composer), composer.parser) for block in sweeps]
    asked = [value for block in blocks for value in block.get("task.periods", ())]
    periods = [int(value.partition("=")[2]) for value in asked]
    if not all("task.periods" in block for block in blocks):
        periods.append(int(plain(planner.composer.config([]), "task")["periods"]))
    return max(periods)


def plan_study(
    name: str, config: DictConfig, overrides: Sequence[str], planner: Planner, included_by: tuple[str, ...] = ()
) -> Plan:
    """Return the points of a study, in the order of its blocks, without duplicates.

    Args:
        name: of the study.
        config: composed config whose `study.blocks` hold the sweeps of each block, by key: all combinations of a
            block are points, except those that `study.constraints` drop. Alternatively, `study.includes` names other
            studies, whose points are this one's.
        overrides: overrides of the command line.
        planner: plans the points.
        included_by: names of the studies that include it, from the outermost on.

    Raises:
        ConfigError: an override cannot be parsed, a value is not allowed, or the study has neither points nor a report.
    """
    node = plain(config, "study")
    blocks = node.get("blocks") if isinstance(node, Mapping) else None
    if isinstance(node, Mapping) and "includes" in node:
        return _joined(name, _included((*included_by, name), node["includes"], overrides, planner))
    if blocks is None and isinstance(node, Mapping) and "report" in node:
        return Plan([], (name,))  # a report that needs no points
    if not isinstance(blocks, Mapping) or not all(isinstance(sweeps, Mapping) for sweeps in blocks.values()):
        raise ConfigError(f"study {name}: needs blocks, each a mapping of keys to sweeps")
    with _named(f"study {name}", ", "):
        constraints = constraints_of(node.get("constraints"))
    of_points = planner.composer.of_points([f"study={name}", *overrides])
    grids = {}
    for block, sweeps in blocks.items():
        with _named(f"study {name}, block {block}"):
            _refuse_settings(sweeps)
            grids[block] = Grid(block_overrides(sweeps, of_points, planner.composer), planner.composer.parser)
    with _named(f"study {name}"):
        points = _Points(name, planner, sum(grid.size for grid in grids.values()), _max_points(config))
    for block, grid in grids.items():
        with _named(f"study {name}, block {block}"):
            points.add(grid, constraints)
    plan = points.plan()
    if not plan:
        left_out = f" and its constraints drop all {plan.combinations} combinations" if plan.combinations else ""
        raise ConfigError(f"study {name}: no design points; its blocks are {', '.join(blocks) or 'none'}{left_out}")
    return plan


def _refuse_settings(sweeps: Mapping[str, Any]) -> None:
    """Refuse settings in a block: they apply to all points.

    Raises:
        ConfigError: a key is that of a setting.
    """
    for key, value in sweeps.items():
        if is_setting(f"{key}="):
            raise ConfigError.at(key, value, "a setting applies to the whole sweep; give it on the command line")


def _included(names: tuple[str, ...], included: Any, overrides: Sequence[str], planner: Planner) -> list[Study]:
    """Return the studies that the last of these studies includes, which the others include."""
    name = names[-1]
    if not isinstance(included, list) or not all(isinstance(other, str) and other != name for other in included):
        raise ConfigError(f"study {name}: includes should be a list of the names of other studies")
    if circle := [other for other in included if other in names]:
        way = " includes ".join([*names[names.index(circle[0]) :], circle[0]])
        raise ConfigError(f"study {name}: includes should not lead back to itself: {way}")
    return [load_study(other, overrides, planner, names) for other in included]


def _joined(name: str, studies: Sequence[Study]) -> Plan:
    """Return the points of studies, which also belong to the one that includes them."""
    both = union([study.plan for study in studies])
    return replace(both, points=[replace(p, studies=(name, *p.studies)) for p in both], studies=(name, *both.studies))


def plan_overrides(overrides: Sequence[str], planner: Planner, max_points: int = MAX_POINTS) -> Plan:
    """Return the points of a grid of sweep overrides, without duplicates.

    Args:
        overrides: the overrides.
        planner: plans the points.
        max_points: maximum number of combinations.

    Raises:
        ConfigError: an override cannot be parsed, a value is not allowed, or there are too many combinations.
    """
    grid = Grid(planner.composer.of_points(overrides), planner.composer.parser)
    points = _Points("", planner, grid.size, max_points)
    points.add(grid, {})
    return points.plan()


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


class _Points:
    """Collects the points of grids.

    Args:
        study: name of the study, or empty.
        planner: plans the points.
        total: number of combinations of all grids.
        max_points: maximum number of combinations.

    Raises:
        ConfigError: there are too many combinations.
    """

    def __init__(self, study: str, planner: Planner, total: int, max_points: int) -> None:
        refuse_large(total, max_points)
        self._studies = (study,) if study else ()
        self._planner = planner
        self._total = total
        self._points: dict[str, PlannedPoint] = {}
        self._combinations = 0
        self._dropped: Counter[tuple[str, str]] = Counter()

    def add(self, grid: Iterable[tuple[str, ...]], constraints: Mapping[str, Constraint]) -> None:
        for overrides in grid:
            self._combinations += 1
            self._planner.progress(self._combinations, self._total)
            parts = self._planner.composer.parts(overrides)
            for name, constraint in constraints.items():
                with _named(f"constraint {name}"):
                    drops = constraint.drops(parts)
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


@contextmanager
def _named(place: str, separator: str = ": ") -> Iterator[None]:
    """Put the place in a study before the message of an error."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{place}{separator}{error}") from error


def _max_points(config: DictConfig) -> int:
    """Return the maximum number of combinations.

    Raises:
        ConfigError: it is not a number of at least 1.
    """
    most = config.get("max_points", MAX_POINTS)
    if type(most) is not int or most < 1:
        raise ConfigError.at("max_points", most, "should be a whole number of at least 1")
    return most
