"""Design points as reports see them: parameters and a run, by design and seed."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import pandas as pd

from rl_design_space._visible import visible
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.config import unlisted
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.learning.measures import SCALARS
from rl_design_space.learning.stage_record import is_scalar_name
from rl_design_space.plan.differences import differing
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.report.parameters import PERIODS, SEED, order
from rl_design_space.tracking.run_frame import ABOUT
from rl_design_space.tracking.selection import Where, alternatives, comparable
from rl_design_space.tracking.tracker import StoredRun


@dataclass(frozen=True, eq=False)
class Point:
    """A design point and its run.

    Attributes:
        parameters: every choice by its name on the command line; lists as text.
        run: its complete run; None if it has none.
        of_plan: the planned point; None if the run was found in the store.
        any_periods: whether its number of periods is no choice: as many as its precision needed, or the longest run of
            the point.
    """

    parameters: Mapping[str, Any]
    run: StoredRun | None
    of_plan: PlannedPoint | None = None
    any_periods: bool = False

    @classmethod
    def planned_with(cls, planned: PlannedPoint, run: StoredRun | None) -> Point:
        """Return a planned point and its run; one that asks for a precision has as many periods as that needed."""
        asks = planned.point.task.precision is not None
        if asks:
            planned = planned.with_periods(run.enough.periods if run and run.enough else planned.point.task.periods)
        return cls({name: comparable(value) for name, value in planned.parameters.items()}, run, planned, asks)

    def with_parameters(self, parameters: Mapping[str, Any]) -> Point:
        """Return the point with other parameters; itself if these are its own."""
        return self if parameters is self.parameters else replace(self, parameters=parameters)

    @property
    def planned(self) -> PlannedPoint:
        """The planned point.

        Raises:
            LookupError: the run was found in the store.
        """
        if self.of_plan is None:
            raise LookupError("this run was found in the store, not in the plan of a study")
        return self.of_plan

    def key(self, names: Iterable[str]) -> tuple[Any, ...]:
        """Return the values of these parameters; None for those that the point does not have."""
        return tuple(self.parameters.get(name) for name in names)

    @cached_property
    def choices(self) -> Mapping[str, Any]:
        """The parameters that make its design: all but its seed, and its number of periods if that is no choice."""
        beside = (SEED, PERIODS) if self.any_periods else (SEED,)
        return {name: value for name, value in self.parameters.items() if name not in beside}

    @cached_property
    def repetition(self) -> Repetition:
        """The design of the point and its seed."""
        return Repetition(tuple(sorted(self.choices.items())), self.parameters.get(SEED))

    def has(self, where: Where) -> bool:
        """Return whether the point has all of these values."""
        return bool(having([self], where))


def having(points: Iterable[Point], where: Where) -> list[Point]:
    """Return the points that have all of these values."""
    wanted = {name: alternatives(values) for name, values in where.items()}
    return [
        point
        for point in points
        if all(name in point.parameters and point.parameters[name] in values for name, values in wanted.items())
    ]


def allowing(points: Iterable[Point], reading: Where) -> list[Point]:
    """Return the points that have each of these values, as far as they have such a parameter."""
    wanted = {name: alternatives(values) for name, values in reading.items()}
    return [
        point
        for point in points
        if all(point.parameters[name] in values for name, values in wanted.items() if name in point.parameters)
    ]


def by_design(points: Iterable[Point]) -> list[list[Point]]:
    """Return points by design: those that differ in their seed alone are together, in the order of their seeds."""
    designs: dict[Hashable, list[Point]] = {}
    for point in sorted(points, key=lambda point: order(point.parameters.get(SEED))):
        designs.setdefault(point.repetition.design, []).append(point)
    return list(designs.values())


def repetition(point: Point) -> Repetition:
    """Return the design of a point and its seed."""
    return point.repetition


def different_choices(points: Iterable[Point]) -> list[str]:
    """Return the names of the choices in which points differ, see `Point.choices`."""
    return differing([point.choices for point in points])


def sample(point: Point) -> tuple[Hashable, int]:
    """Return the design and seed of a point, everything but its number of periods, and that number."""
    others = tuple(sorted((name, value) for name, value in point.parameters.items() if name != PERIODS))
    return others, int(point.parameters[PERIODS])


def smallest(points: Iterable[Point]) -> list[Point]:
    """Return points without those of which there is a smaller sample: equal in all but fewer periods."""
    samples: dict[Hashable, list[Point]] = {}
    for point in points:
        samples.setdefault(sample(point)[0], []).append(point)
    return [min(each, key=lambda point: sample(point)[1]) for each in samples.values()]


def largest(points: Iterable[Point]) -> list[Point]:
    """Return points without those of which there is a larger sample: recorded, and equal in all but more periods."""
    samples: dict[Hashable, list[Point]] = {}
    for point in points:
        samples.setdefault(sample(point)[0], []).append(point)
    return [max(each, key=lambda point: (point.run is not None, sample(point)[1])) for each in samples.values()]


def points_of_frame(frame: pd.DataFrame, *, every: bool = True) -> list[Point]:
    """Return the points of runs that were found in the store, each once; control characters in names are shown.

    Args:
        frame: as `RunReader.frame` returns it.
        every: whether runs with fewer periods are included of which there are longer ones.
    """
    points = []
    once = frame.drop_duplicates("fingerprint").reset_index()
    names, shown = [visible(str(name)) for name in once], lru_cache(maxsize=None)(visible)
    for record, known in zip(once.to_dict("records"), once.notna().to_numpy(), strict=True):
        there: dict[str, Any] = {
            name: shown(value) if isinstance(value, str) else value
            for name, value, is_known in zip(names, record.values(), known.tolist(), strict=True)
            if is_known
        }
        scalars = {name: there.pop(name) for name in list(there) if name in SCALARS or is_scalar_name(name)}
        run = StoredRun(record["run_id"], scalars=scalars, artifacts=record["artifacts"])
        parameters = {name: value for name, value in there.items() if name not in ABOUT}
        points.append(Point(parameters, run, any_periods=not every))
    return points if every else largest(points)


def with_defaults(points: Sequence[Point], asked: Sequence[str] = ()) -> list[Point]:
    """Return points with the defaults that their parameters leave out, of names that others list or that are asked for.

    Args:
        points: the points.
        asked: texts in which names may stand, such as the arguments of a command.
    """
    names = unlisted.named_defaults((point.parameters for point in points), asked)
    if not names:
        return list(points)
    found = []
    for point in points:
        left_out = {name: comparable(value) for name, value in unlisted.left_out(point.parameters, names).items()}
        found.append(point.with_parameters({**point.parameters, **left_out}) if left_out else point)
    return found


def frame_with_defaults(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a frame of runs with the defaults that some leave out and others list."""
    options = [name for name in frame if name in OPTION_GROUPS]
    listed = dict.fromkeys(frame.columns)
    chosen: list[Any] = frame[options].drop_duplicates().to_dict("records")
    candidates = unlisted.named_defaults([listed, *chosen])
    found = frame.copy(deep=False)
    for name in candidates:
        choices = [each for each in (name.partition(".")[0], f"{name.partition('.')[0]}.source") if each in frame]
        rows = frame.loc[frame[name].isna(), choices].to_dict("records")
        there = [{str(key): value for key, value in row.items() if not pd.isna(value)} for row in rows]
        values = [unlisted.left_out(row, [name]).get(name) for row in there]
        filled = frame[name].astype(object)
        filled[frame[name].isna()] = [None if value is None else comparable(value) for value in values]
        found[name] = filled.infer_objects()
    return found


def other_samples(points: Iterable[Point], of: Iterable[Point]) -> list[Point]:
    """Return those of some points that are samples of others, of another size."""
    known = {sample(point) for point in of}
    designs = {design for design, _ in known}
    return [point for point in points if sample(point)[0] in designs and sample(point) not in known]
