"""What a verdict hangs on: the exact decomposition of its variance over readings and judgements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rl_design_space._arrays import FloatArray

#: Alternatives that are read at the same time, by number.
Departures = frozenset[int]


@dataclass(frozen=True)
class Component:
    """A part of the variance.

    Attributes:
        factors: names of the factors whose interaction it is, or of the one factor whose effect it is.
        share: of the whole variance.
    """

    factors: frozenset[str]
    share: float


def decompose(
    verdicts: FloatArray, readings: Sequence[Departures], alternatives: Sequence[str], judgements: Sequence[str]
) -> list[Component]:
    """Return the shares of the variance of a verdict, the largest first; none if the verdict is always the same.

    Each of m alternatives is taken with probability 1/m, independently, and each judgement uniformly. Readings of
    three and more departures come out as their single ones and pairs do together: the decomposition is exact for the
    second-order expansion (cut-HDMR) of the verdict around the reading without departures, so on every reading that was
    run. A pair that was not run, as its alternatives exclude each other, has no interaction.

    Args:
        verdicts: (readings, …) 1 where the claim holds, else 0; one more axis for each judgement.
        readings: the departures of each reading; the empty one and all single ones among them.
        alternatives: the factor that each alternative belongs to.
        judgements: the factor of each axis behind the first.
    """
    of = {reading: verdicts[number] for number, reading in enumerate(readings)}
    chance = 1 / len(alternatives) if alternatives else 0.0
    found: dict[frozenset[str], float] = {}
    for departures, effect in _centred(of, len(alternatives), chance).items():
        named = frozenset(alternatives[each] for each in departures)
        scale = (chance * (1 - chance)) ** len(departures)
        for axes, variance in _analysed(effect):
            factors = named | {judgements[axis] for axis in axes}
            if factors:
                found[factors] = found.get(factors, 0.0) + scale * variance
    whole = sum(found.values())
    if whole <= 1e-12:
        return []
    shares = (Component(factors, variance / whole) for factors, variance in found.items())
    return sorted((part for part in shares if part.share > 1e-9), key=lambda part: (-part.share, sorted(part.factors)))


def first_order(components: Iterable[Component], factor: str) -> float:
    """Return the share of the variance that a factor explains alone."""
    return sum(part.share for part in components if part.factors == {factor})


def total(components: Iterable[Component], factor: str) -> float:
    """Return the share of the variance that a factor has to do with, alone or with others."""
    return sum(part.share for part in components if factor in part.factors)


def _centred(of: Mapping[Departures, FloatArray], number: int, chance: float) -> dict[Departures, FloatArray]:
    """Return the coefficients of the expansion in alternatives that have mean 0."""
    nothing = of[Departures()]
    alone = [of[Departures({each})] - nothing for each in range(number)]
    together = {}
    for one, other in combinations(range(number), 2):
        both = Departures({one, other})
        if both in of:
            together[both] = of[both] - nothing - alone[one] - alone[other]
    centred: dict[Departures, FloatArray] = {Departures(): nothing + chance * sum(alone, np.zeros_like(nothing))}
    for each in range(number):
        centred[Departures({each})] = alone[each].copy()
    for both, effect in together.items():
        centred[Departures()] = centred[Departures()] + chance**2 * effect
        for each in both:
            centred[Departures({each})] += chance * effect
    return {**centred, **together}


def _analysed(effect: FloatArray) -> Iterable[tuple[tuple[int, ...], float]]:
    """Yield each set of axes and the mean square of the effect that belongs to it alone (analysis of variance)."""
    means: dict[tuple[int, ...], FloatArray] = {}
    every = tuple(range(effect.ndim))
    for size in range(effect.ndim + 1):
        for axes in combinations(every, size):
            others = tuple(axis for axis in every if axis not in axes)
            own = effect.mean(axis=others, keepdims=True)
            for smaller in range(size):
                for inner in combinations(axes, smaller):
                    own = own - means[inner]
            means[axes] = own
            yield axes, float((own**2).mean())
