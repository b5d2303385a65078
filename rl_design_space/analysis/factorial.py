"""Factorials: which choices differ between points, and grids of all combinations of some of their values."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rl_design_space.errors import ConfigError

#: Factorials, at most, that points are divided into.
_MOST = 50
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

    def levels(self, points: Sequence[Mapping[str, Hashable]]) -> list[Level]:
        """Return the value of each point; None stands for a parameter that it does not have."""
        return list(zip(*([point.get(name) for point in points] for name in self.parameters), strict=True))


@dataclass(frozen=True)
class Factorial:
    """Points of all combinations of some levels.

    Attributes:
        factors: what differs, in the order of the axes.
        levels: of each factor, in the order of the axis.
        points: index of the point of each combination, an axis for each factor.
    """

    factors: tuple[Factor, ...]
    levels: tuple[tuple[Level, ...], ...]
    points: NDArray[np.intp]


@dataclass(frozen=True)
class Grids:
    """Factorials that points consist of.

    Attributes:
        factors: all choices that differ between the points.
        parts: the factorials, the largest first; a point may belong to several.
        alone: number of points that belong to none.
        unknown: choices that differ between the points, but within no factorial.
        empty: combinations without a point, a few of them, as on the command line.
        combinations: number of all combinations.
        missing: how many of them have no point.
    """

    factors: tuple[Factor, ...]
    parts: tuple[Factorial, ...]
    alone: int
    unknown: tuple[str, ...]
    empty: tuple[str, ...]
    combinations: float
    missing: float

    @property
    def is_whole(self) -> bool:
        """Whether all combinations have a point."""
        return not self.missing

    @property
    def gap(self) -> str:
        """Which combinations have no point, as a clause."""
        names = ", ".join(factor.name for factor in self.factors)
        more = self.missing - len(self.empty)
        rest = f", and {more:,.0f} more" if more else ""
        return (
            f"{names}: {self.missing:,.0f} of {self.combinations:,.0f} combinations have no point: "
            f"{'; '.join(self.empty)}{rest}"
        )


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
        columns = [[point.get(name) for point in points] for name in parameters]
        if len(set(zip(*columns, strict=True))) == np.prod([len(set(column)) for column in columns], dtype=float):
            found += alone
        else:
            found.append(Factor(choice, tuple(parameters)))
    return found


def grids(points: Sequence[Mapping[str, Hashable]], names: Sequence[str]) -> Grids:
    """Return the factorials that points consist of.

    If combinations are missing, as in a union of grids, the first factorial is the largest that is found by leaving out
    the emptiest level again and again; the next ones are found in the same way around points that no factorial has yet.

    Args:
        points: values of parameters by name; no two are equal in `names`.
        names: of the parameters that differ.

    Raises:
        ConfigError: no two points are equal in all choices but one; some of the missing combinations are named.
    """
    among = tuple(factors(points, names))
    of_points = [factor.levels(points) for factor in among]
    levels = [list(dict.fromkeys(each)) for each in of_points]
    places = [{level: place for place, level in enumerate(each)} for each in levels]
    codes = np.empty((len(points), len(among)), np.intp)
    for column, each, place in zip(codes.T, of_points, places, strict=True):
        column[:] = [place[level] for level in each]
    parts, left = _covering(codes, levels, among)
    varying = {factor for part in parts for factor in part.factors}
    total = float(np.prod([len(each) for each in levels], dtype=float))
    there = {tuple(row) for row in codes.tolist()}
    empty = (key for key in product(*map(range, map(len, levels))) if key not in there)
    named = [
        " ".join(described(f, each[i]) for f, each, i in zip(among, levels, key, strict=True))
        for key, _ in zip(empty, range(_NAMED), strict=False)
    ]
    unknown = tuple(factor.name for factor in among if factor not in varying)
    found = Grids(among, tuple(parts), left, unknown, tuple(named), total, total - len(there))
    if not parts:
        raise ConfigError(f"{found.gap}; run them, or choose runs of which all combinations are there")
    return found


def _covering(
    codes: NDArray[np.intp], levels: Sequence[list[Level]], among: tuple[Factor, ...]
) -> tuple[list[Factorial], int]:
    """Return factorials, and the number of points in none of them."""
    parts: list[Factorial] = []
    covered, alone = np.zeros((2, len(codes)), dtype=bool)
    around: int | None = None
    while len(parts) + alone.sum() < _MOST:
        inside = _grown(codes, around)
        if inside.sum() > 1:
            parts.append(_factorial(codes, inside, levels, among))
            covered |= inside
        elif around is not None:
            alone[around] = True
        left = np.flatnonzero(~covered & ~alone)
        if not len(left):
            break
        around = int(left[0])
    parts.sort(key=lambda part: -part.points.size)
    return parts, int((~covered).sum())


def _grown(codes: NDArray[np.intp], around: int | None) -> NDArray[np.bool_]:
    """Return which points make a factorial, that of a given point if there is one."""
    inside = np.ones(len(codes), dtype=bool)
    if around is not None and not ((codes != codes[around]).sum(axis=1) == 1).any():
        return np.asarray(np.arange(len(codes)) == around)
    while True:
        counts = [np.bincount(column) for column in codes[inside].T]
        sizes = np.array([np.count_nonzero(count) for count in counts], dtype=float)
        total = sizes.prod()
        if total == inside.sum():
            return _extended(codes, inside)
        emptiest = []
        for factor, count in enumerate(counts):
            share = np.where(count > 0, count * sizes[factor] / total, np.inf)
            if around is not None:
                share[codes[around, factor]] = np.inf
            level = int(share.argmin())
            # Of equally empty levels, one of the factor with the most of them costs least.
            emptiest.append((float(share[level]), -float(sizes[factor]), factor, level))
        *_, factor, level = min(emptiest)
        inside &= codes[:, factor] != level


def _extended(codes: NDArray[np.intp], inside: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a factorial with all levels added whose combinations with the others are there."""
    used: list[NDArray[np.bool_]] = [np.bincount(column[inside], minlength=column.max() + 1) > 0 for column in codes.T]
    among = np.array([each[column] for each, column in zip(used, codes.T, strict=True)])  # (factors, points)
    for factor, before in enumerate(used):
        elsewhere = np.delete(among, factor, axis=0).all(axis=0)
        size = np.prod([other.sum() for place, other in enumerate(used) if place != factor], dtype=float)
        full = np.bincount(codes[elsewhere, factor], minlength=len(before)) == size
        used[factor] = np.asarray(before | full)
        among[factor] = used[factor][codes[:, factor]]
    return np.asarray(among.all(axis=0))


def _factorial(
    codes: NDArray[np.intp], inside: NDArray[np.bool_], levels: Sequence[list[Level]], among: tuple[Factor, ...]
) -> Factorial:
    used = [np.unique(column) for column in codes[inside].T]
    varying = [place for place, each in enumerate(used) if len(each) > 1]
    array = np.full([len(used[place]) for place in varying], -1, dtype=np.intp)
    for index in np.flatnonzero(inside):
        array[tuple(int(np.searchsorted(used[place], codes[index, place])) for place in varying)] = index
    return Factorial(
        tuple(among[place] for place in varying),
        tuple(tuple(levels[place][level] for level in used[place]) for place in varying),
        array,
    )


def described(factor: Factor, level: Level) -> str:
    """Return a level as on the command line: `exploration=linear exploration.k=0.03`."""
    pairs = zip(factor.parameters, level, strict=True)
    return " ".join(f"{name}={value}" for name, value in pairs if value is not None)
