"""Published grades against measured values: could any limits give the published order?"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, permutations
from typing import Literal, Protocol

#: Verdict on an order, see `order`.
Order = Literal["some limits", "no limits", "cannot be told"]


class Interval(Protocol):
    """A 95 % interval."""

    @property
    def low(self) -> float: ...

    @property
    def high(self) -> float: ...


def order(ranks: Sequence[int], estimates: Sequence[Interval], *, larger: bool) -> Order:
    """Return whether any limits would give rows the grades that were published for them.

    Limits are sensible if they are monotone: a row with the higher grade has the higher value, or the lower one where
    less is more. Such limits exist if and only if, of any two rows with different grades, the one with the higher grade
    lies strictly beyond the other; rows of equal grade may have any values, as all of them may lie between two limits.

    A pair of rows is decided if their intervals are disjoint, so of two 95 % intervals one errs in less than 1 % of
    cases, and the verdict on three rows needs no further correction. "Never" is an interval without an upper end.

    Args:
        ranks: published grades as numbers; more is higher.
        estimates: intervals of the measured values; unknown ends (NaN) decide nothing.
        larger: whether the higher grade is for the larger value.

    Returns:
        `some limits` if every such pair is in the published order, `no limits` if one is in the opposite order or
        certainly equal, otherwise `cannot be told`.
    """
    pairs = [(one, other) for one, other in permutations(range(len(ranks)), 2) if ranks[one] > ranks[other]]
    beyond = [(one, other) if larger else (other, one) for one, other in pairs]
    if any(estimates[more].high <= estimates[less].low for more, less in beyond):
        return "no limits"
    if all(estimates[more].low > estimates[less].high for more, less in beyond):
        return "some limits"
    return "cannot be told"


def between(ranks: Sequence[int], values: Sequence[float], *, larger: bool) -> list[tuple[float, float]]:
    """Return where limits would lie: between the values of neighbouring grades, from the highest grade down.

    Args:
        ranks: published grades as numbers; more is higher.
        values: in the published order, see `order`.
        larger: whether the higher grade is for the larger value.

    Returns:
        The ends of each gap, the smaller one first.
    """
    by_rank = {rank: [v for r, v in zip(ranks, values, strict=True) if r == rank] for rank in sorted(set(ranks))[::-1]}
    if larger:
        return [(max(lower), min(higher)) for higher, lower in pairwise(by_rank.values())]
    return [(max(higher), min(lower)) for higher, lower in pairwise(by_rank.values())]
