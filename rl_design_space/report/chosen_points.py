"""Points that are chosen by the values of their parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from typing import Any, Self

from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report.ordering import Ordering
from rl_design_space.report.parameters import text
from rl_design_space.report.points import Point, allowing, by_design, different_choices, having
from rl_design_space.tracking.selection import Where, alternatives, no_such_value


class ChosenPoints:
    """Design points.

    Args:
        points: in any order.
        name: what the points are called in messages.
    """

    def __init__(self, points: Iterable[Point], name: str) -> None:
        self.points = list(points)
        self._name = name
        #: Of the values of parameters.
        self.ordering = Ordering()

    def check(self, names: Iterable[str], prefix: str = "") -> None:
        """Refuse names of parameters that no point has.

        Args:
            names: of the parameters.
            prefix: of each name in messages.

        Raises:
            ConfigError: there is such a name; the nearest right one is named.
        """
        for name in names:
            if not any(name in point.parameters for point in self.points):
                known = {name for point in self.points for name in point.parameters}
                raise ConfigError.unknown("parameter of these runs", name, known, prefix)

    def check_values(self, where: Where) -> None:
        """Refuse values of parameters that no point has.

        Raises:
            ConfigError: there is such a value, or no point has a parameter of such a name.
        """
        self.check(where)
        for name, wanted in where.items():
            there = {point.parameters[name] for point in self.points if name in point.parameters}
            if there.isdisjoint(alternatives(wanted)):
                ordered = sorted(there, key=lambda value: self.ordering.key(name, value))
                raise no_such_value(name, wanted, list(map(text, ordered)))

    def under(self, reading: Where) -> Self:
        """Return the same without the points that have one of these parameters with another value.

        Raises:
            ConfigError: no point has a parameter of such a name.
        """
        self.check(reading)
        return self.only(allowing(self.points, reading))

    def only(self, points: Iterable[Point]) -> Self:
        """Return the same with some of the points alone."""
        runs = copy(self)  # with the results that are read already
        runs.points = list(points)
        return runs

    def ordered(self, values: Mapping[str, Sequence[Any]]) -> Self:
        """Return the same with another order of the values of some parameters.

        Raises:
            ConfigError: no point has a parameter of such a name, or one with such a value.
        """
        if not values:
            return self
        self.check(values, "order.")
        runs = copy(self)
        known = {name: {point.parameters.get(name) for point in self.points} for name in values}
        runs.ordering = self.ordering.replaced(values, known)
        return runs

    def where(self, where: Where) -> list[Point]:
        """Return the points that have these values, recorded or not, in their order.

        Raises:
            ConfigError: no point has a parameter of such a name.
        """
        self.check(where)
        return having(self.points, where)

    def one(self, where: Where) -> Point:
        """Return the only point that has these values.

        Raises:
            ConfigError: there is none, or there are several.
        """
        found = self.where(where)
        if len(found) != 1:
            raise self._not_one(where, found)
        return found[0]

    def seeds(self, where: Where) -> list[Point]:
        """Return the only design that has these values: its points, one for each seed.

        Raises:
            ConfigError: there is none, or there are several.
        """
        designs = by_design(found := self.where(where))
        if len(designs) != 1:
            raise self._not_one(where, found)
        return designs[0]

    def _not_one(self, where: Where, found: Sequence[Point]) -> ConfigError:
        wanted = " ".join(f"{name}={value}" for name, value in where.items())
        others = different_choices(found) or differing([point.parameters for point in found])
        differ = f"; they differ in {', '.join(others)}" if others else ""
        return ConfigError(f"{wanted}: should be one point of {self._name}, not {len(found)}{differ}")

    def grouped(
        self, names: Sequence[str], points: Iterable[Point] | None = None
    ) -> dict[tuple[Any, ...], list[Point]]:
        """Return points by their values of parameters, in the order of these values.

        Args:
            names: of the parameters.
            points: to be grouped; all if None.

        Raises:
            ConfigError: no point has a parameter of such a name.
        """
        self.check(names)
        groups: dict[tuple[Any, ...], list[Point]] = {}
        for point in self.points if points is None else points:
            groups.setdefault(point.key(names), []).append(point)
        return dict(sorted(groups.items(), key=lambda group: self.ordering.keys(names, group[0])))
