"""Pairs of readings that came near to making a claim hold, and what a third reading beside them does."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import pandas as pd

from rl_design_space.report.multiverse_outcomes import ClaimOutcomes, Row
from rl_design_space.report.multiverse_points import Space

_COLUMNS = ["claim", "measure", "statistic", "reading", "factor", "triples", "hold", "nearest", "nearest_factor"]
#: The registered limits are the first.
_REGISTERED = 0


def near_frame(found: Mapping[str, ClaimOutcomes], space: Space, near: float) -> pd.DataFrame:
    """Return the pairs of readings that came near, see `Multiverse.near`.

    Args:
        found: outcomes of the claims by name.
        space: what the specifications are made of.
        near: largest factor by which a value may be beyond its limit.

    Returns:
        claim, measure, statistic, reading (the pair), factor (of the value that decides, within the limit: below 1);
        triples (number of readings with a third departure that were run), hold (number of those under which the claim
        holds), nearest (the one that comes nearest or is farthest inside), nearest_factor.
    """
    rows = [row for each in found.values() for row in _of_claim(each, space, near)]
    return pd.DataFrame(rows, columns=_COLUMNS)


def _of_claim(found: ClaimOutcomes, space: Space, near: float) -> Iterator[tuple[object, ...]]:
    wording = found.wording
    judged: dict[tuple[int, int], dict[int, Row]] = {}
    for row in found.rows:
        if row.threshold == _REGISTERED:
            judged.setdefault((row.measure, row.statistic), {})[row.reading] = row
    for (measure, statistic), rows in judged.items():
        for pair in _near_pairs(rows, found.standing, space, near):
            third = [row for number, row in rows.items() if space.readings[number] > space.readings[pair]]
            told = [row for row in third if not math.isnan(row.margin)]
            nearest = max(told, key=lambda row: row.margin, default=None)
            yield (
                wording.name, wording.measures[measure], wording.statistics[statistic], space.reading(pair),
                math.exp(rows[pair].margin), len(third), sum(row.holds is True for row in third),
                space.reading(nearest.reading) if nearest else "", math.exp(nearest.margin) if nearest else math.nan,
            )  # fmt: skip


def _near_pairs(rows: Mapping[int, Row], standing: list[int], space: Space, near: float) -> Iterator[int]:
    """Yield the numbers of the pairs that came near under one judgement; none if the claim holds under any reading."""
    every = {number: row for number, row in rows.items() if number < space.every}
    if any(row.holds is True for row in every.values()):
        return
    place = {reading: number for number, reading in enumerate(space.readings)}
    for number, row in every.items():
        pair = space.readings[number]
        if len(pair) == 2 and row.holds is False and row.margin >= -math.log(near):
            fewer = [frozenset[int](), *(frozenset({each}) for each in pair)]
            before = [every[standing[place[each]]] for each in fewer]
            if all(row.margin > each.margin for each in before):
                yield number
