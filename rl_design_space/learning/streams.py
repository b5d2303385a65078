"""Where randomness comes from: one stream a period for its layout, one for the agent's behaviour.

The layout stream depends on seed and period alone, so all design points of equal size meet the same starts and
goals (common random numbers) and can be compared in pairs. `SeedSequence` is the only part of NumPy's random
machinery used, because its output is guaranteed never to change between versions.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Scalar = TypeVar("Scalar", bound=np.generic)

_LAYOUT, _BEHAVIOUR = 0, 1


def _words(seed: int, period: int, stream: int, count: int) -> NDArray[np.uint64]:
    return np.random.SeedSequence(seed, spawn_key=(period, stream)).generate_state(count, np.uint64).astype(np.uint64)


def _distinct(words: NDArray[np.uint64], cells: int) -> Iterator[int]:
    """The first steps of a Fisher-Yates shuffle of the cells, one a word."""
    moved: dict[int, int] = {}
    for position, word in enumerate(words):
        drawn = position + (int(word) * (cells - position) >> 64)
        yield moved.get(drawn, drawn)
        moved[drawn] = moved.get(position, position)


@lru_cache(maxsize=32)
def layouts(seed: int, cells: int, n_goals: int, periods: int) -> NDArray[np.int32]:
    """Start and goals of every period: (periods, 1 + n_goals) int32 cell numbers, distinct in a row.

    With more goals, start and first goals of a period stay the same.
    """
    rows = [list(_distinct(_words(seed, period, _LAYOUT, 1 + n_goals), cells)) for period in range(periods)]
    return _frozen(np.array(rows, dtype=np.int32))


@lru_cache(maxsize=32)
def behaviour_states(seed: int, periods: int) -> NDArray[np.uint64]:
    """Initial state of every period's generator: (periods, 4) uint64, for xoshiro256++."""
    return _frozen(np.array([_words(seed, period, _BEHAVIOUR, 4) for period in range(periods)]))


def _frozen(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """Cached arrays are shared, so nobody may write to them."""
    array.setflags(write=False)
    return array
