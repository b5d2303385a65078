"""Plans: the design points of a sweep, each once, with the overrides that describe them."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, overload

from rl_design_space.config import user_config
from rl_design_space.config.overrides import is_setting, with_absent
from rl_design_space.design import DesignPoint
from rl_design_space.plan.code_identity import source_parameters
from rl_design_space.plan.cost import expected_steps
from rl_design_space.plan.describe import parameters, present_fields, resolved_config
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.plan.run_names import RunNames, typed_keys

if TYPE_CHECKING:
    from rl_design_space.learning.result import LearningCurves

#: Beginnings of the overrides of the number of periods.
_PERIODS = ("task.periods=", "task.periods_at_most=", "task.precision=", "task.precision_of=")


@dataclass(frozen=True, slots=True)
class PlannedPoint:
    """A design point and the overrides that describe it.

    Attributes:
        point: the point itself.
        options: name of the chosen option of every config group, e.g. {"world": "torus"}.
        overrides: the command-line overrides that describe the point.
        studies: names of the studies that the point belongs to.
        fingerprint: the identity of the point, see `plan.fingerprint`.
        begun: a result of its first periods, which are not learned again.
        names: what its run is named after; its overrides if None.
    """

    point: DesignPoint
    options: Mapping[str, str]
    overrides: tuple[str, ...]
    studies: tuple[str, ...]
    fingerprint: str
    begun: LearningCurves | None = field(default=None, compare=False, repr=False)
    names: RunNames | None = field(default=None, compare=False, repr=False)

    @classmethod
    def of(
        cls,
        point: DesignPoint,
        options: Mapping[str, str],
        overrides: tuple[str, ...] = (),
        studies: tuple[str, ...] = (),
    ) -> PlannedPoint:
        """Return a planned point with its fingerprint.

        Raises:
            ConfigError: a field of an option is not a plain value.
        """
        return cls(point, options, overrides, studies, fingerprint(point))

    @property
    def periods_begun(self) -> int:
        """Number of periods that are not learned again."""
        return 0 if self.begun is None else len(self.begun.steps)

    def with_periods(self, periods: int, begun: LearningCurves | None = None) -> PlannedPoint:
        """Return the same point with exactly so many periods, whatever number or precision it asks for.

        Args:
            periods: their number.
            begun: a result of the first of them.
        """
        point = replace(self.point, task=self.point.task.with_periods(periods))
        others = (override for override in self.overrides if not override.lstrip("+").startswith(_PERIODS))
        overrides = (*others, f"{_PERIODS[0]}{periods}")
        return replace(self, point=point, overrides=overrides, fingerprint=fingerprint(point), begun=begun)

    @property
    def parameters(self) -> dict[str, Any]:
        """Every choice by its name on the command line: options first, then values.

        The code identity of user components is included, e.g. `representation.source`.
        """
        present = present_fields(self.point)
        options = {group: option for group, option in self.options.items() if group in present}
        own = dict(pair for name in present for pair in source_parameters(getattr(self.point, name), name))
        return {**options, **own, **parameters(self.point)}

    @property
    def config(self) -> dict[str, Any]:
        """The point as a nested config, with every `_target_` and every value."""
        return resolved_config(self.point)

    @property
    def measured_by(self) -> str:
        """The name of the program that measured its result; empty if this package learns it."""
        return ""

    @property
    def name(self) -> str:
        """A short description: the overrides that are not settings."""
        return " ".join(override for override in self.overrides if not is_setting(override)) or "defaults"

    def run_name(self, parameters: Mapping[str, Any]) -> str:
        """Return the name of the run of this point, whose parameters the caller has computed, see `RunNames`."""
        return (self.names or RunNames([self], typed_keys(self.overrides))).name(parameters)

    @property
    def command(self) -> str:
        """The command that runs this point alone."""
        return shlex.join(["rl-design-space", *user_config.flags(), *self.overrides])


@dataclass(frozen=True)
class Dropped:
    """The number of combinations that a constraint of a study dropped."""

    study: str
    constraint: str
    why: str
    count: int


@dataclass(frozen=True)
class Plan(Sequence[PlannedPoint]):
    """The points of a sweep, each once.

    Attributes:
        points: in the order in which the grids list them.
        studies: names of the studies that they come from.
        combinations: number of combinations in the grids, including dropped ones and duplicates.
        dropped: one entry for each constraint that dropped combinations.
        whole: number of points of the plan that this one is a shard of; that of this plan if it is no shard.
    """

    points: Sequence[PlannedPoint]
    studies: tuple[str, ...] = ()
    combinations: int = 0
    dropped: tuple[Dropped, ...] = ()
    whole: int = -1

    def __post_init__(self) -> None:
        if self.whole < 0:
            object.__setattr__(self, "whole", len(self.points))

    @overload
    def __getitem__(self, index: int) -> PlannedPoint: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[PlannedPoint]: ...
    def __getitem__(self, index: int | slice) -> PlannedPoint | Sequence[PlannedPoint]:
        return self.points[index]

    def __len__(self) -> int:
        return len(self.points)

    def __iter__(self) -> Iterator[PlannedPoint]:
        return iter(self.points)

    @property
    def name(self) -> str:
        """The names of its studies, or `sweep` if it has none."""
        return ",".join(self.studies) or "sweep"

    @property
    def duplicates(self) -> int:
        """Number of combinations that describe the same point as another one."""
        return self.combinations - sum(dropped.count for dropped in self.dropped) - self.whole

    @property
    def axes(self) -> dict[str, dict[str, int]]:
        """The parameters in which the points differ, with the number of points by value, in order of appearance."""
        values: dict[str, Counter[str]] = {}
        for point in with_absent([planned.parameters for planned in self.points]):
            for name, value in point.items():
                values.setdefault(name, Counter())[str(value)] += 1
        return {name: dict(counts) for name, counts in values.items() if len(counts) > 1}

    def named(self, overrides: Iterable[str] = ()) -> Plan:
        """Return the plan with runs that are named after what differs between its points.

        Args:
            overrides: that were typed, which the names include.
        """
        names = RunNames(self.points, typed_keys(overrides))
        return replace(self, points=[replace(planned, names=names) for planned in self.points])

    def shard(self, number: int, of: int) -> Plan:
        """Return one of `of` shards of about equal cost; the first is number 1.

        Which shard a point belongs to does not depend on the order of the points.
        """
        ranked = sorted(self.points, key=lambda planned: (-expected_steps(planned.point), planned.fingerprint))
        mine = {planned.fingerprint for planned in ranked[number - 1 :: of]}
        return replace(self, points=[planned for planned in self.points if planned.fingerprint in mine])
