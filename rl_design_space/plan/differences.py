"""Parameters in which design points differ."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

#: Every choice of a point by its name; choices that its options do not have are missing.
Parameters = Mapping[str, Any]


def differing(points: Sequence[Parameters], beside: Collection[str] = ()) -> list[str]:
    """Return the parameters in which points differ.

    A value that follows from an option is left out if the option itself differs: `reward.step` adds nothing to `reward`
    if each reward has one `reward.step`.

    Args:
        points: parameters of each point.
        beside: parameters that are known to differ.
    """
    names = dict.fromkeys(name for point in points for name in point)
    vary = [name for name in names if len({point.get(name) for point in points}) > 1]
    return [name for name in vary if name not in beside and not _decided_by_option(name, points, {*vary, *beside})]


def _decided_by_option(name: str, points: Iterable[Parameters], vary: Collection[str]) -> bool:
    option, dot, _ = name.partition(".")
    if not dot or option not in vary:
        return False
    values: dict[Any, set[Any]] = {}
    for point in points:
        values.setdefault(point.get(option), set()).add(point.get(name))
    return all(len(each) == 1 for each in values.values())


def grid(points: Sequence[Parameters]) -> dict[str, int] | None:
    """Return the parameters whose values, all combined, are the points, with their numbers of values; None if none are.

    Parameters that follow from the others are left out, such as a slope that each representation has its own of.
    """
    names = differing(points)
    for name in reversed(names):
        if not _is_whole(points, names):
            rest = [other for other in names if other != name]
            names = rest if len(_combinations(points, rest)) == len(points) else names
    return {name: len(_combinations(points, [name])) for name in names} if _is_whole(points, names) else None


def _is_whole(points: Sequence[Parameters], names: Sequence[str]) -> bool:
    return math.prod(len(_combinations(points, [name])) for name in names) == len(points)


def _combinations(points: Iterable[Parameters], names: Sequence[str]) -> set[tuple[Any, ...]]:
    return {tuple(point.get(name) for name in names) for point in points}
