"""All claims at once: the specification under which most of them hold, and how well placebos would do."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Placebos that are drawn where there are more than can be listed.
DRAWS = 10_000
#: Placebos that are computed at once; few enough for the cache of a core.
_AT_ONCE = 100

Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Slot:
    """A place in a claim where it names a best value.

    Attributes:
        expected: the value that it names.
        holds: (readings, measures, statistics, thresholds), whether the claim's parts about it hold, for each value of
            the grid in its place.
    """

    expected: Hashable
    holds: Mapping[Any, Booleans]

    @property
    def others(self) -> list[Any]:
        """The other values of the grid, each a placebo."""
        return [value for value in self.holds if value != self.expected]


@dataclass(frozen=True)
class Outcomes:
    """Outcomes of a claim under every specification.

    Attributes:
        claim: its name.
        role: of its measures; claims of one role are measured alike in a joint specification.
        rest: (readings, measures, statistics, thresholds), whether everything in it holds but what its slots are about.
        slots: where it names a best value.
    """

    claim: str
    role: str
    rest: Booleans
    slots: Sequence[Slot] = field(default_factory=tuple)

    @property
    def holds(self) -> Booleans:
        """Whether the claim holds under each specification."""
        return self.with_values([slot.expected for slot in self.slots])

    def with_values(self, values: Sequence[Any]) -> Booleans:
        """Return whether the claim would hold with other values in its slots."""
        holds = self.rest
        for slot, value in zip(self.slots, values, strict=True):
            holds = holds & slot.holds[value]
        return holds


@dataclass(frozen=True)
class Joint:
    """A specification for all claims.

    Attributes:
        reading, statistic, threshold: indices of the choices.
        measures: index of the measure by role.
        claims: names of the claims that hold.
    """

    reading: int
    statistic: int
    threshold: int
    measures: Mapping[str, int]
    claims: tuple[str, ...]


@dataclass(frozen=True)
class Placebo:
    """How well claims do whose best values are drawn from the rest of the grids.

    Attributes:
        searched: share of the placebos of which as many claims hold, or more, under the specification that suits them
            best.
        same: that share under the specification that suits the real claims best.
        draws: number of placebos.
        mean: number of claims of a placebo that hold under the specification that suits it best, on average.
    """

    searched: float
    same: float
    draws: int
    mean: float


def best_joint(claims: Sequence[Outcomes], departures: NDArray[np.int_], within: Booleans) -> Joint:
    """Return the specification under which most claims hold; among equals, the one with the fewest departures.

    Args:
        claims: with as many readings and thresholds each; statistics as many, or one that stands for all.
        departures: (readings, statistics, thresholds) number of choices that depart from the registered ones.
        within: (readings, statistics, thresholds) which of them may be chosen.
    """
    scores = {role: _score(claims, role, departures.shape) for role in dict.fromkeys(each.role for each in claims)}
    # The first measure of a role is the registered one; another one is a departure, too.
    best = {role: score.max(axis=1) for role, score in scores.items()}
    moved = sum(((score.argmax(axis=1) > 0).astype(int) for score in scores.values()), departures)
    total = np.where(within, np.sum(list(best.values()), axis=0), -1)
    most = total == total.max()
    reading, statistic, threshold = np.unravel_index(np.where(most, moved, np.iinfo(int).max).argmin(), total.shape)
    where = int(reading), int(statistic), int(threshold)
    measures = {role: int(score[where[0], :, where[1], where[2]].argmax()) for role, score in scores.items()}
    holding = tuple(each.claim for each in claims if _at(each, measures[each.role], *where))
    return Joint(*where, measures, holding)


def placebo(claims: Sequence[Outcomes], joint: Joint, within: Booleans, seed: int = 0) -> Placebo:
    """Return how likely it is that a paper with arbitrary best values does as well.

    Each value that a claim calls the best is replaced by another one of its grid; everything else stays.

    Args:
        claims: all of them.
        joint: the specification under which most of them hold.
        within: (readings, statistics, thresholds) which specifications were searched.
        seed: of the draws, if there are more placebos than `DRAWS`.
    """
    shape = within.shape
    fixed = {role: _score([each for each in claims if not each.slots], role, shape) for role in _roles(claims)}
    varied = [each for each in claims if each.slots]
    roles = dict.fromkeys(each.role for each in varied)
    base = np.sum([fixed[role].max(axis=1) for role in fixed if role not in roles] or [np.zeros(shape, int)], axis=0)
    sure = sum(each.claim in joint.claims for each in claims if not each.slots)
    reached, same, most = [], [], len(joint.claims)
    for held in _held(varied, seed):
        total: Any = base
        there: Any = sure
        for role in roles:
            score = fixed[role]
            for each, holds in zip(varied, held, strict=True):
                if each.role == role:
                    score = score + _filled(holds, shape)
                    statistic = min(joint.statistic, holds.shape[3] - 1)
                    there = there + holds[:, joint.reading, joint.measures[role], statistic, joint.threshold]
            total = total + score.max(axis=-3)
        reached.append(total[:, within].max(axis=1))
        same.append(there)
    if not reached:
        return Placebo(math.nan, math.nan, 0, math.nan)
    counts = np.concatenate(reached)
    return Placebo(
        float((counts >= most).mean()),
        float((np.concatenate(same) >= most).mean()),
        len(counts),
        float(counts.mean()),
    )


def as_good(claim: Outcomes, seed: int = 0) -> float:
    """Return the share of a claim's placebos that hold under as many specifications; NaN if it names no best value."""
    if not claim.slots:
        return math.nan
    own = claim.holds.mean()
    others = [holds.mean(axis=(1, 2, 3, 4)) >= own for (holds,) in _held([claim], seed)]
    return float(np.concatenate(others).mean())


def _held(claims: Sequence[Outcomes], seed: int) -> Iterator[list[Booleans]]:
    """Yield whether each claim holds with other values in all slots: (placebos, readings, …), some placebos at a time.

    All of them if there are not too many, else draws.
    """
    slots = [slot for each in claims for slot in each.slots]
    sizes = [len(slot.others) for slot in slots]
    number = math.prod(sizes) if slots else 0
    rng = np.random.default_rng(seed)
    drawn = np.array(
        list(product(*map(range, sizes)))
        if number <= DRAWS
        else [[rng.integers(size) for size in sizes] for _ in range(DRAWS)]
    )
    tables = [np.array([slot.holds[value] for value in slot.others]) for slot in slots]
    for start in range(0, len(drawn) if number else 0, _AT_ONCE):
        remaining = iter(zip(tables, drawn[start : start + _AT_ONCE].T, strict=True))
        held = []
        for each in claims:
            holds = np.broadcast_to(each.rest, (len(drawn[start : start + _AT_ONCE]), *each.rest.shape))
            for _ in each.slots:
                table, places = next(remaining)
                holds = holds & table[places]
            held.append(holds)
        yield held


def _roles(claims: Sequence[Outcomes]) -> dict[str, None]:
    return dict.fromkeys(each.role for each in claims)


def _score(claims: Sequence[Outcomes], role: str, shape: tuple[int, ...]) -> NDArray[np.int_]:
    """Return how many claims of a role hold: (readings, measures, statistics, thresholds)."""
    readings, statistics, thresholds = shape
    measures = max((each.rest.shape[1] for each in claims if each.role == role), default=1)
    score = np.zeros((readings, measures, statistics, thresholds), dtype=int)
    for each in claims:
        if each.role == role:
            score += _filled(each.holds, (readings, statistics, thresholds))
    return score


def _filled(holds: Booleans, shape: tuple[int, ...]) -> Booleans:
    return np.broadcast_to(holds, (*holds.shape[:-2], shape[1], holds.shape[-1]))


def _at(claim: Outcomes, measure: int, reading: int, statistic: int, threshold: int) -> bool:
    holds = claim.holds
    return bool(holds[reading, measure, min(statistic, holds.shape[2] - 1), threshold])
