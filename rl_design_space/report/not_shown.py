"""Runs that make no line of a report, because nothing differs from them in its parameter alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rl_design_space.report.parameters import order, text
from rl_design_space.report.points import Point

#: Beginning of each sentence.
NOT_SHOWN = "Not shown:"


def not_shown(parameter: str, others: Sequence[str], alone: Sequence[Point], shown: Sequence[Point]) -> Iterator[str]:
    """Yield sentences on runs that are left out: those of values that no line has, and the others.

    Args:
        parameter: along the lines.
        others: parameters in which the runs differ besides.
        alone: runs that are equal in these to no run with another value of the parameter.
        shown: runs of the lines.
    """
    known = {point.parameters[parameter] for point in shown}
    left_out = {point.parameters[parameter] for point in alone} - known
    values: dict[tuple[str, ...], list[Any]] = {}
    for value in sorted(left_out, key=order):
        own = [point for point in alone if point.parameters[parameter] == value]
        rest = [point for point in (*shown, *alone) if point.parameters[parameter] != value]
        values.setdefault(tuple(_apart(own, rest, others)), []).append(value)
    for names, each in values.items():
        number = sum(point.parameters[parameter] in each for point in alone)
        which = ", ".join(f"{parameter}={text(value)}" for value in each)
        why = f"same {' or '.join(names)}" if names else "same values of everything else"
        yield f"{NOT_SHOWN} {which} ({_runs(number)}), because no run with another {parameter} has the {why}."
    if number := sum(point.parameters[parameter] in known for point in alone):
        yield f"{NOT_SHOWN} {_runs(number)}, from which no other run differs in {parameter} alone."


def _runs(number: int) -> str:
    return f"{number} run{'s' if number > 1 else ''}"


def _apart(own: Sequence[Point], rest: Sequence[Point], names: Sequence[str]) -> list[str]:
    """Return the parameters of which no value is on both sides."""
    return [name for name in names if not _values(own, name) & _values(rest, name)]


def _values(points: Sequence[Point], name: str) -> set[Any]:
    return {point.parameters.get(name) for point in points}
