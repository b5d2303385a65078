"""Studies: named unions of grids of design points."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

from omegaconf import DictConfig

from rl_design_space._paths import leads_out
from rl_design_space.config import user_config
from rl_design_space.config.assemble import Parts
from rl_design_space.config.build import build, plain
from rl_design_space.config.compose import shipped_config
from rl_design_space.config.explain import explained
from rl_design_space.config.grammar import parse
from rl_design_space.config.measure_name import with_own_measures
from rl_design_space.config.overrides import is_setting, shared
from rl_design_space.design import Task
from rl_design_space.errors import ConfigError
from rl_design_space.plan.block import block_overrides, refuse_settings
from rl_design_space.plan.collect import Collector, named
from rl_design_space.plan.constraint import constraints_of
from rl_design_space.plan.grid import MAX_POINTS, Grid, axes
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.variations import variations_of
from rl_design_space.plan.varied import Varied

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
        usual_periods: the most periods of a point without the overrides; of included studies, those of the least.
        included: the studies that it includes.
        report_options: arguments of the command that writes its report, beside the overrides.
        planner: has planned it, and plans others, see `another`; None in another process.
    """

    name: str
    overrides: tuple[str, ...]
    config: DictConfig
    plan: Plan
    usual_periods: int = _PERIODS
    included: tuple[Study, ...] = ()
    report_options: tuple[str, ...] = ()
    planner: Planner | None = field(default=None, compare=False, repr=False)

    @property
    def command(self) -> str:
        """The command that runs the study."""
        return shlex.join(["rl-design-space", *user_config.flags(), f"study={self.name}", *self.overrides])

    @property
    def report_command(self) -> str:
        """The command that writes its report."""
        words = ["rl-design-report", *user_config.flags(), self.name, *self.overrides, *self.report_options]
        return shlex.join(words)

    @property
    def mark(self) -> str:
        """A note for figures whose points have fewer periods than the study's file asks for; empty otherwise.

        That is the case, too, if a precision decides on their number.
        """
        most, usual = _most_periods(self.plan), self.usual_periods
        if any(planned.point.task.precision is not None for planned in self.plan):
            return ""
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

    def another(self, name: str) -> Study:
        """Return the study of a name, with the overrides of this one; if this one includes it, it is planned already.

        Raises:
            ConfigError: there is no such study, or it cannot be planned with these overrides.
        """
        included = self.planner.included.get(self.overrides, {}) if self.planner else {}
        with shipped_config():
            return included.get(name) or load_study(name, self.overrides, self.planner)


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
        usual = min((each.usual_periods for each in studies if each.plan), default=_PERIODS)
        plan, included = _joined(name, studies, config, overrides, planner), tuple(studies)
    else:
        plan, included = plan_study(name, config, overrides, planner), ()
        changed = plan and not all(map(is_setting, overrides))
        usual = _usual_periods(config, planner) if changed else _most_periods(plan)
    return Study(name, overrides, config, plan, usual, included, planner=planner)


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
            studies, whose points are this one's. `study.variations` adds all of these points as readings change them.
        overrides: overrides of the command line.
        planner: plans the points.
        included_by: names of the studies that include it, from the outermost on.

    Raises:
        ConfigError: an override cannot be parsed, a value is not allowed, or the study has neither points nor a report.
    """
    node = plain(config, "study")
    blocks = node.get("blocks") if isinstance(node, Mapping) else None
    if isinstance(node, Mapping) and "includes" in node:
        included = _included((*included_by, name), node["includes"], overrides, planner)
        return _joined(name, included, config, overrides, planner)
    if blocks is None and isinstance(node, Mapping) and "report" in node:
        return Plan([], (name,))  # a report that needs no points
    if not isinstance(blocks, Mapping) or not all(isinstance(sweeps, Mapping) for sweeps in blocks.values()):
        raise ConfigError(f"study {name}: needs blocks, each a mapping of keys to sweeps")
    of_points = planner.composer.of_points([f"study={name}", *overrides])
    with named(f"study {name}", ", "):
        constraints, varied = constraints_of(node.get("constraints")), _varied(node, of_points, planner)
    grids = {}
    for block, sweeps in blocks.items():
        with named(f"study {name}, block {block}"):
            refuse_settings(sweeps)
            grids[block] = Grid(block_overrides(sweeps, of_points, planner.composer), planner.composer.parser)
    with named(f"study {name}"):
        total = sum(grid.size for grid in grids.values()) * (1 + (varied.count if varied else 0))
        points = Collector(name, planner, total, _max_points(config), constraints, varied)
    for block, grid in grids.items():
        with named(f"study {name}, block {block}"):
            points.add(grid)
    plan = points.plan()
    if not plan:
        left_out = f" and its constraints drop all {plan.combinations} combinations" if plan.combinations else ""
        raise ConfigError(f"study {name}: no design points; its blocks are {', '.join(blocks) or 'none'}{left_out}")
    _check(name, varied)
    return plan


def _varied(node: Mapping[str, Any], overrides: Sequence[str], planner: Planner) -> Varied | None:
    """Return what changes the points of a study; None if its file names no variations."""
    variations = variations_of(node.get("variations"))
    return Varied(variations, overrides, planner.composer) if variations else None


def _check(name: str, varied: Varied | None) -> None:
    if varied:
        with named(f"study {name}, variations", ", "):
            varied.check()


def _included(names: tuple[str, ...], included: Any, overrides: Sequence[str], planner: Planner) -> list[Study]:
    """Return the studies that the last of these studies includes, which the others include."""
    name = names[-1]
    if not isinstance(included, list) or not all(isinstance(other, str) and other != name for other in included):
        raise ConfigError(f"study {name}: includes should be a list of the names of other studies")
    if circle := [other for other in included if other in names]:
        way = " includes ".join([*names[names.index(circle[0]) :], circle[0]])
        raise ConfigError(f"study {name}: includes should not lead back to itself: {way}")
    known = planner.included.setdefault(tuple(overrides), {})  # several studies may include the same one
    return [known.get(each) or known.setdefault(each, load_study(each, overrides, planner, names)) for each in included]


def _joined(
    name: str, studies: Sequence[Study], config: DictConfig, overrides: Sequence[str], planner: Planner
) -> Plan:
    """Return the points of studies, which also belong to the one that includes them, and as readings change them."""
    both = union([study.plan for study in studies])
    points = [replace(planned, studies=(name, *planned.studies)) for planned in both]
    plan = replace(both, points=points, studies=(name, *both.studies))
    with named(f"study {name}", ", "):
        node = plain(config, "study")
        varied = _varied(node, planner.composer.of_points(overrides), planner)
        if varied is None:
            return plan
        constraints = constraints_of(node.get("constraints"))
        changed = Collector(name, planner, len(plan) * varied.count, _max_points(config), constraints, varied)
    for planned in plan:
        with named(f"study {name}, variations of {planned.name}"):
            values = {field.name: getattr(planned.point, field.name) for field in fields(planned.point)}
            changed.vary(Parts(values, planned.options), planned.overrides)
    _check(name, varied)
    return union([plan, changed.plan()])


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
    points = Collector("", planner, grid.size, max_points)
    points.add(grid)
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


def _max_points(config: DictConfig) -> int:
    """Return the maximum number of combinations.

    Raises:
        ConfigError: it is not a number of at least 1.
    """
    most = config.get("max_points", MAX_POINTS)
    if type(most) is not int or most < 1:
        raise ConfigError.at("max_points", most, "should be a whole number of at least 1")
    return most
