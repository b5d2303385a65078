"""A plan: the design points of a sweep, each once, and how they were asked for."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, overload

from rl_design_space.config import user_config
from rl_design_space.config.overrides import is_setting
from rl_design_space.design import DesignPoint
from rl_design_space.plan.code_identity import sources
from rl_design_space.plan.cost import expected_moves
from rl_design_space.plan.describe import parameters
from rl_design_space.plan.fingerprint import fingerprint


@dataclass(frozen=True, slots=True)
class PlannedPoint:
    """A design point and how it was asked for.

    Attributes:
        point: the point itself.
        options: name of the chosen option of every config group, e.g. {"world": "torus"}.
        overrides: the command-line overrides that describe the point.
        studies: names of the studies that the point belongs to.
        fingerprint: the point's identity, see `sweep.fingerprint`.
    """

    point: DesignPoint
    options: Mapping[str, str]
    overrides: tuple[str, ...]
    studies: tuple[str, ...]
    fingerprint: str

    @classmethod
    def of(
        cls,
        point: DesignPoint,
        options: Mapping[str, str],
        overrides: tuple[str, ...] = (),
        studies: tuple[str, ...] = (),
    ) -> PlannedPoint:
        """The planned point with the fingerprint that it has.

        Raises:
            ConfigError: a field of an option is not a plain value.
        """
        return cls(point, options, overrides, studies, fingerprint(point))

    @property
    def parameters(self) -> dict[str, Any]:
        """Every choice by its name on the command line: options first, then values.

        What the code of the user's own components is recognised by is there as well, e.g. `representation.source`.
        """
        own = dict(
            pair for field in fields(self.point) for pair in sources(getattr(self.point, field.name), field.name)
        )
        return {**self.options, **own, **parameters(self.point)}

    @property
    def name(self) -> str:
        """A short description: what was asked for beside the defaults."""
        return " ".join(override for override in self.overrides if not is_setting(override)) or "defaults"

    @property
    def command(self) -> str:
        """The command that runs this point alone."""
        return shlex.join(["rl-design-space", *user_config.flags(), *self.overrides])


@dataclass(frozen=True)
class Dropped:
    """How many combinations a constraint of a study left out, and why."""

    study: str
    constraint: str
    why: str
    count: int


@dataclass(frozen=True)
class Plan(Sequence[PlannedPoint]):
    """The points of a sweep, each once.

    Attributes:
        points: in the order in which they were asked for.
        studies: names of the studies that they come from.
        combinations: how many were asked for, those dropped and repeated included.
        dropped: by the constraints that dropped any.
        whole: how many points the plan has that this one is a part of.
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
        """Of its studies, or plainly a sweep."""
        return ",".join(self.studies) or "sweep"

    @property
    def duplicates(self) -> int:
        """Combinations that are the same point as another one."""
        return self.combinations - sum(dropped.count for dropped in self.dropped) - self.whole

    @property
    def axes(self) -> dict[str, dict[str, int]]:
        """The parameters in which the points differ: how many points have each value, in order of appearance."""
        values: dict[str, Counter[str]] = {}
        for planned in self.points:
            for name, value in planned.parameters.items():
                values.setdefault(name, Counter())[str(value)] += 1
        return {name: dict(counts) for name, counts in values.items() if len(counts) > 1}

    def shard(self, number: int, of: int) -> Plan:
        """One of several parts of about equal cost that together are the whole: the first is number 1.

        A point belongs to the same part whatever order the points were asked for in.
        """
        ranked = sorted(self.points, key=lambda planned: (-expected_moves(planned.point), planned.fingerprint))
        mine = {planned.fingerprint for planned in ranked[number - 1 :: of]}
        return replace(self, points=[planned for planned in self.points if planned.fingerprint in mine])
