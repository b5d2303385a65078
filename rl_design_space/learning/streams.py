"""Random streams: for each period one for each of its layouts and one for the agent's behaviour.

Stream 0 is that of the first layout, 1 of behaviour, 2 and more of the layouts that stages draw then. Layout streams
depend on seed and period alone, so all design points of equal size have the same starts and goals (common random
numbers) and comparisons are paired. `SeedSequence` is the only part of NumPy's random module in use, because its output
is guaranteed never to change between versions.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Scalar = TypeVar("Scalar", bound=np.generic)
Words = NDArray[np.uint32]

_LAYOUT, _BEHAVIOUR = 0, 1

# Constants of SeedSequence (NumPy's random/bit_generator.pyx).
_INIT_A, _MULTIPLIER_A = 0x43B0D7E5, 0x931E8875
_INIT_B, _MULTIPLIER_B = 0x8B51F9DD, 0x58F38DED
_MIX_LEFT, _MIX_RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
_POOL = 4
_32 = np.uint64(32)


def random_words(seed: int, stream: int, periods: int, count: int) -> NDArray[np.uint64]:
    """Return words of one stream of every period, (periods, count).

    The words of period p are `SeedSequence(seed, spawn_key=(p, stream)).generate_state(count, np.uint64)`, computed for
    all periods at once: one by one, they would take as long as the learning.
    """
    pool = np.tile(np.random.SeedSequence(seed).pool[:, np.newaxis], periods)
    # The pool of the seed alone has used one hash for each of its words and one for each pair of them.
    constant = _INIT_A * pow(_MULTIPLIER_A, _POOL * _POOL, 2**32)
    for key in (np.arange(periods, dtype=np.uint32), np.full(periods, stream, dtype=np.uint32)):
        for at in range(_POOL):
            hashed, constant = _hashed(key, constant, _MULTIPLIER_A)
            mixed = pool[at] * _MIX_LEFT - hashed * _MIX_RIGHT
            pool[at] = mixed ^ (mixed >> np.uint32(16))
    halves = np.empty((2 * count, periods), dtype=np.uint64)
    constant = _INIT_B
    for at in range(2 * count):
        halves[at], constant = _hashed(pool[at % _POOL], constant, _MULTIPLIER_B)
    return np.ascontiguousarray((halves[::2] | (halves[1::2] << _32)).T)


def _hashed(words: Words, constant: int, multiplier: int) -> tuple[Words, int]:
    """Return words hashed as in SeedSequence, and the constant of the next hash."""
    following = constant * multiplier % 2**32
    product = (words ^ np.uint32(constant % 2**32)) * np.uint32(following)
    return product ^ (product >> np.uint32(16)), following


def below(words: NDArray[np.uint64], limit: int) -> NDArray[np.int32]:
    """Return a number in 0 … limit - 1 for each random word: the upper 64 bits of word · limit."""
    factor = np.uint64(limit)
    return (((words >> _32) * factor + ((words & np.uint64(0xFFFFFFFF)) * factor >> _32)) >> _32).astype(np.int32)


def _distinct(words: NDArray[np.uint64], cells: int) -> NDArray[np.int32]:
    """Return the beginning of a Fisher-Yates shuffle of the cells: (periods, count), distinct in a row."""
    shuffled = np.empty(words.shape, dtype=np.int32)
    exchanged: list[tuple[NDArray[np.int32], NDArray[np.int32]]] = []

    def content(places: NDArray[np.int32]) -> NDArray[np.int32]:
        found = places
        for place, moved_there in exchanged:
            found = np.where(places == place, moved_there, found)
        return found

    for position, column in enumerate(words.T):
        places = position + below(column, cells - position)
        shuffled[:, position] = content(places)
        exchanged.append((places, content(np.full_like(places, position))))
    return shuffled


@lru_cache(maxsize=32)
def layouts(seed: int, cells: int, n_goals: int, periods: int, number: int = 0) -> NDArray[np.int32]:
    """Return start and goals of every period: (periods, 1 + n_goals) int32 cell numbers, distinct in a row.

    The start and the first goals of a period do not depend on the number of goals.

    Args:
        seed: of the point.
        cells: number of cells.
        n_goals: number of goals.
        periods: number of periods.
        number: of the layout among those that a period has one after the other.
    """
    return _frozen(_distinct(layout_words(seed, periods, 1 + n_goals, number), cells))


def layout_words(seed: int, periods: int, count: int, number: int) -> NDArray[np.uint64]:
    """Return random words of a layout of every period, (periods, count): of the stream with its number, see above."""
    return random_words(seed, _BEHAVIOUR + number if number else _LAYOUT, periods, count)


@lru_cache(maxsize=32)
def behaviour_states(seed: int, periods: int) -> NDArray[np.uint64]:
    """Return the initial state of every period's generator: (periods, 4) uint64, for xoshiro256++."""
    return _frozen(random_words(seed, _BEHAVIOUR, periods, 4))


def _frozen(array: NDArray[Scalar]) -> NDArray[Scalar]:
    """Make an array read-only, because cached arrays are shared."""
    array.setflags(write=False)
    return array
