"""Factorials: which choices differ between points, and whether all their combinations are there."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rl_design_space.errors import ConfigError

#: Choices that are fixed, at most, so that all combinations of the others are there.
_MOST_FIXED = 2
#: Combinations without a point that a message names.
_NAMED = 4

#: A value of a choice: the values of all parameters that belong to it.
Level = tuple[Hashable, ...]


@dataclass(frozen=True)
class Factor:
    """A choice that differs between points.

    Attributes:
        name: of its parameter, or of the choice whose parameters differ together.
        parameters: names of its parameters.
    """

    name: str
    parameters: tuple[str, ...]

    def level(self, point: Mapping[str, Hashable]) -> Level:
        """Return the value of a point; None stands for a parameter that it does not have."""
        return tuple(point.get(name) for name in self.parameters)


@dataclass(frozen=True)
class Factorial:
    """Points of all combinations of some levels.

    Attributes:
        factors: what differs, in the order of the axes.
        levels: of each factor, in the order of the axis.
        points: index of the point of each combination, an axis for each factor.
        fixed: what is equal in all of these points, but not in the points of others.
    """

    factors: tuple[Factor, ...]
    levels: tuple[tuple[Level, ...], ...]
    points: NDArray[np.intp]
    fixed: Mapping[str, Level]


def factors(points: Sequence[Mapping[str, Hashable]], names: Sequence[str]) -> list[Factor]:
    """Return the choices that differ between points.

    Parameters of one choice, such as `exploration` and `exploration.k`, are factors of their own if all their
    combinations occur. Otherwise they are one: the levels of `exploration` are then schedules with their values.

    Args:
        points: values of parameters by name.
        names: of the parameters that differ, in the order of the factors.
    """
    choices: dict[str, list[str]] = {}
    for name in names:
        choices.setdefault(name.partition(".")[0], []).append(name)
    found = []
    for choice, parameters in choices.items():
        alone = [Factor(name, (name,)) for name in parameters]
        crossed = len({tuple(factor.level(point) for factor in alone) for point in points})
        if crossed == np.prod([len({factor.level(point) for point in points}) for factor in alone]):
            found += alone
        else:
            found.append(Factor(choice, tuple(parameters)))
    return found


def factorials(points: Sequence[Mapping[str, Hashable]], names: Sequence[str]) -> list[Factorial]:
    """Return the factorials that points consist of.

    Where combinations are missing, as in a union of grids, one choice, or two, are fixed: the points of each of its values are a
    factorial of their own. Among the choices that can be fixed, those are taken that make the fewest factorials.

    Args:
        points: values of parameters by name; no two are equal in `names`.
        names: of the parameters that differ.

    Raises:
        ConfigError: the points are not such a union; some of the missing combinations are named.
    """
    among = factors(points, names)
    everything = list(range(len(points)))
    for fixed in range(_MOST_FIXED + 1):
        found = list(_divided(points, everything, among, fixed))
        if found:
            return min(found, key=len)
    raise ConfigError(_incomplete(points, among))


def _divided(
    points: Sequence[Mapping[str, Hashable]], which: list[int], among: Sequence[Factor], fixed: int
) -> Iterator[list[Factorial]]:
    """Yield every way to divide points into factorials by fixing so many factors."""
    if not fixed:
        if whole := _whole(points, which, among):
            yield [whole]
        return
    for factor in among:
        groups: dict[Level, list[int]] = {}
        for index in which:
            groups.setdefault(factor.level(points[index]), []).append(index)
        others = [other for other in among if other != factor]
        parts = [next(_divided(points, group, others, fixed - 1), None) for group in groups.values()]
        if len(groups) > 1 and all(parts):
            yield [
                Factorial(each.factors, each.levels, each.points, {factor.name: level, **each.fixed})
                for level, part in zip(groups, parts, strict=True)
                for each in part or ()
            ]


def _whole(points: Sequence[Mapping[str, Hashable]], which: list[int], among: Sequence[Factor]) -> Factorial | None:
    """Return the factorial of all these points; None if combinations are missing."""
    levels = {factor: tuple(dict.fromkeys(factor.level(points[index]) for index in which)) for factor in among}
    varying = tuple(factor for factor in among if len(levels[factor]) > 1)
    shape = tuple(len(levels[factor]) for factor in varying)
    if np.prod(shape, dtype=float) != len(which):
        return None
    places = {factor: {level: place for place, level in enumerate(levels[factor])} for factor in varying}
    array = np.full(shape, -1, dtype=np.intp)
    for index in which:
        array[tuple(places[factor][factor.level(points[index])] for factor in varying)] = index
    return Factorial(varying, tuple(levels[factor] for factor in varying), array, {}) if (array >= 0).all() else None


def _incomplete(points: Sequence[Mapping[str, Hashable]], among: Sequence[Factor]) -> str:
    """Return a message that names combinations without a point."""
    levels = [list(dict.fromkeys(factor.level(point) for point in points)) for factor in among]
    there = {tuple(factor.level(point) for factor in among) for point in points}
    total = int(np.prod([len(each) for each in levels], dtype=float))
    missing = (key for key in product(*levels) if key not in there)
    named = [
        " ".join(described(factor, level) for factor, level in zip(among, key, strict=True))
        for key, _ in zip(missing, range(_NAMED), strict=False)
    ]
    more = f", and {total - len(there) - len(named)} more" if total - len(there) > len(named) else ""
    return (
        f"{', '.join(factor.name for factor in among)}: {total - len(there)} of {total} combinations have no point: "
        f"{'; '.join(named)}{more}; run them, or select runs of which all combinations are there"
    )


def described(factor: Factor, level: Level) -> str:
    """Return a level as on the command line: `exploration=linear exploration.k=0.03`."""
    pairs = zip(factor.parameters, level, strict=True)
    return " ".join(f"{name}={value}" for name, value in pairs if value is not None)
