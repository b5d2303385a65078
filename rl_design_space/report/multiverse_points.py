"""Points of a multiverse by what they are under the decided reading, and by how a reading changes them."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from rl_design_space.errors import ConfigError
from rl_design_space.report.points import Point
from rl_design_space.tracking.selection import Where, comparable, matches

#: The reading without departures.
DECIDED = "as decided"
#: Between the names of readings that are taken together.
AND = " + "
#: Parameters that do not tell points of a multiverse apart.
_APART = ("task.periods",)
#: Values of parameters that a reading changes.
Departure = frozenset[tuple[str, Hashable]]
#: Number of a point of the decided reading.
Base = int


@dataclass(frozen=True)
class Alternative:
    """Another reading of one place in a text.

    Attributes:
        name: as the study calls it.
        departure: what it changes.
        of: values of the points that it is about; all if empty.
        key: the factor that it belongs to.
    """

    name: str
    departure: Departure
    of: Where
    key: str

    @property
    def says(self) -> str:
        """What it changes, as on the command line."""
        return ", ".join(f"{key}={value}" for key, value in sorted(self.departure)) + self._whose

    def denied(self, decided: Mapping[str, Any]) -> str:
        """Return what the decided reading says in its place."""
        return ", ".join(f"{key}={decided[key]}" for key, _ in sorted(self.departure)) + self._whose

    @property
    def _whose(self) -> str:
        return f" ({', '.join(map(str, self.of.values()))})" if self.of else ""


def alternatives(readings: Mapping[str, Where], apart: Mapping[str, str], points: Iterable[Point]) -> list[Alternative]:
    """Return the alternatives of a study's readings.

    Args:
        readings: what each changes, by name.
        apart: pairs of parameters; alternatives of the first count separately for each value of the second.
        points: all points of the study.
    """
    found: list[Alternative] = []
    for name, values in readings.items():
        departure = frozenset((key, comparable(value)) for key, value in values.items())
        by = next((apart[key] for key in values if key in apart), None)
        if by is None:
            found.append(Alternative(name, departure, {}, ", ".join(values)))
            continue
        having = [point for point in points if all(point.parameters.get(key) == value for key, value in departure)]
        found += [
            Alternative(f"{name} ({value})", departure, {by: value}, f"{', '.join(values)} ({value})")
            for value in dict.fromkeys(point.parameters[by] for point in having)
        ]
    return found


def readings_of(found: Sequence[Alternative], order: int) -> list[frozenset[int]]:
    """Return the readings by the numbers of their alternatives: none, each alone, and all that go together.

    Args:
        found: the alternatives.
        order: largest number of alternatives in a reading.
    """
    apart = {
        frozenset(pair)
        for pair in combinations(range(len(found)), 2)
        if {key for key, _ in found[pair[0]].departure} & {key for key, _ in found[pair[1]].departure}
        and found[pair[0]].of == found[pair[1]].of
    }
    several = [
        frozenset(together)
        for size in range(2, order + 1)
        for together in combinations(range(len(found)), size)
        if not any(frozenset(pair) in apart for pair in combinations(together, 2))
    ]
    return [frozenset(), *(frozenset({number}) for number in range(len(found))), *several]


@dataclass(frozen=True)
class Space:
    """What the specifications are made of.

    Attributes:
        alternatives: other readings of single places.
        readings: by the numbers of their alternatives; those that every claim is judged under are first.
        every: number of readings that every claim is judged under; those after them are for claims that have their
            points.
        thresholds: names of the sets of limits.
        decided: values of the parameters that readings change.
    """

    alternatives: Sequence[Alternative]
    readings: Sequence[frozenset[int]]
    every: int
    thresholds: Sequence[str]
    decided: Mapping[str, Any]

    def reading(self, number: int) -> str:
        """Return the name of a reading."""
        return AND.join(self.alternatives[each].name for each in sorted(self.readings[number])) or DECIDED

    @property
    def says(self) -> list[tuple[str, str]]:
        """What each alternative says, and what the decided reading says in its place."""
        return [(each.says, each.denied(self.decided)) for each in self.alternatives]


class ReadPoints:
    """Points under any reading.

    Args:
        points: of the study.
        decided: values of the parameters that readings change.
        common: values of parameters that all points have unless a claim says otherwise.
        found: the alternatives.
    """

    def __init__(
        self, points: Iterable[Point], decided: Mapping[str, Any], common: Where, found: Sequence[Alternative]
    ) -> None:
        self._decided = {key: comparable(value) for key, value in decided.items()}
        self._common = common
        self._alternatives = found
        self._points: dict[tuple[Base, Departure], Point] = {}
        self._found: dict[str, list[Base]] = {}
        #: Points of the decided reading, by the number of what tells them apart.
        self.bases: dict[Base, Point] = {}
        self._changed: dict[tuple[Base, int], Departure] = {}
        numbers: dict[Hashable, Base] = {}
        for point in points:
            base, departure = numbers.setdefault(self._base(point), len(numbers)), self._departure(point)
            known = self._points.get((base, departure))
            if known is None or (known.run is None and point.run is not None):
                self._points[base, departure] = point
        for (base, departure), point in self._points.items():
            if not departure:
                self.bases[base] = point

    def where(self, where: Where) -> Sequence[Base]:
        """Return the points of the decided reading that have these values.

        Raises:
            LookupError: there is none.
        """
        key = _text(where)
        if key not in self._found:
            wanted = {**self._common, **where}
            self._found[key] = [base for base, point in self.bases.items() if point.has(wanted)]
        if not self._found[key]:
            raise LookupError(f"no point has {key}")
        return self._found[key]

    def one(self, where: Where) -> Base:
        """Return the only point of the decided reading that has these values.

        Raises:
            ConfigError: there are several.
            LookupError: there is none.
        """
        found = self.where(where)
        if len(found) > 1:
            raise ConfigError(f"{_text(where)}: should be one point of the multiverse, not {len(found)}")
        return found[0]

    def read(self, base: Base, reading: Iterable[int]) -> Point:
        """Return a point as a reading changes it: by the alternatives that are about it.

        Raises:
            LookupError: the study does not have it.
        """
        departure = self.departure(base, reading)
        if (base, departure) not in self._points:
            raise LookupError(f"not in this study: {_text(dict(departure))} for {self.bases[base].planned.name}")
        return self._points[base, departure]

    def has(self, bases: Iterable[Base], reading: Iterable[int]) -> bool:
        """Return whether the study has all of these points as a reading changes them."""
        return all((base, self.departure(base, reading)) in self._points for base in bases)

    def departure(self, base: Base, reading: Iterable[int]) -> Departure:
        """Return what a reading changes of a point: by the alternatives that are about it and make another point."""
        return frozenset().union(*(self._change(base, number) for number in reading))

    def _change(self, base: Base, number: int) -> Departure:
        if (base, number) not in self._changed:
            each = self._alternatives[number]
            acts = self.bases[base].has(each.of) and (base, each.departure) in self._points
            self._changed[base, number] = each.departure if acts else frozenset()
        return self._changed[base, number]

    def _departure(self, point: Point) -> Departure:
        return frozenset(
            (key, point.parameters[key])
            for key, value in self._decided.items()
            if key in point.parameters and not matches(value, point.parameters[key])
        )

    def _base(self, point: Point) -> Hashable:
        return tuple(sorted((k, v) for k, v in point.parameters.items() if k not in self._decided and k not in _APART))


def _text(where: Mapping[str, Any]) -> str:
    return " ".join(f"{name}={value}" for name, value in where.items())
