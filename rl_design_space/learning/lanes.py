"""Periods that are learned side by side, each in a lane of its own.

One period alone is slow: the next decision waits for the last update. Several periods have nothing to wait for from
each other, so the processor works on one lane while another waits, and decides and updates for four or eight lanes
with one instruction.

The numbers of all lanes lie column after column, a column having a place for every lane. That columns begin at
constants, and that a vectorised loop never writes to the array of Q-values that it reads, is what lets the compiler
see that lanes do not depend on each other.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Lanes that there is room for: enough that nothing waits, few enough that the Q-matrices stay in the cache. Not a
#: power of two, so that the columns do not compete for the same places of the cache.
LANES = 24
#: Lanes that the vector instructions serve at a time; so few lanes as `FEW` are faster without them.
WIDTH, FEW = 8, 4

_CACHE_LINE = 64

# Indices are unsigned, so that no index has to be tested for being negative.
index = np.uint64

#: State of the random generator, its word of this turn, and ε · 2^32.
S0, S1, S2, S3, WORD, THRESHOLD = (index(column * LANES) for column in range(6))
#: The action chosen, where the row of the Q-matrix that is seen begins, the agent's cell, where the entries of the
#: present success counter begin, and the entry that the action has led to.
ACTION, ROW, CELL, STAGE, ENTRY = (index(column * LANES) for column in range(6, 11))
#: Moves that an action of several moves has made.
EXECUTED = index(11 * LANES)
#: Where the updated Q-value lies, which of the values seen it is (n_actions if none), and whether the trial has ended.
UPDATED, SEEN, ENDED = (index(column * LANES) for column in range(12, 15))
#: Moves made in this trial, its number, that of the period, and whose part of the tables the lane uses.
MOVES, TRIAL, PERIOD, HOME = (index(column * LANES) for column in range(15, 19))
COLUMNS = 19

#: The chosen action's Q-value before and after its update; of an action of several moves, its return, the discount of
#: what follows, and the best Q-value there.
OLD, NEW, RETURN, DISCOUNT, BEST = (index(column * LANES) for column in range(5))
REAL_COLUMNS = 5

#: Kinds of cells that a move can lead to, the two low bits of an entry: without a goal, with one that is not due,
#: with the due one, with the due one that is the last.
PLAIN, OUT_OF_ORDER, SUB_GOAL, FINAL_GOAL = (index(kind) for kind in range(4))
KIND = index(3)


class Lanes(NamedTuple):
    """What `learn` keeps of the periods in flight.

    Attributes:
        running: (1,) int64, lanes in use.
        numbers: (COLUMNS · LANES,) uint64, see the columns above.
        reals: (REAL_COLUMNS · LANES,) float64, likewise.
        values: ((n_actions + 1) · LANES,) float64, the Q-values that each lane's agent sees, a column for every
            action, and one for what is to be dropped.
        q: (lanes, n_goals · cells · n_actions) float64, Q-matrices, by row and action.
        entries: (lanes, n_goals · cells) uint32, what a move onto a cell leads to, by success counter and cell: where
            in `q` the row begins that is seen there, a multiple of four, plus one of the four kinds.
        passed: (1 + longest action, LANES) uint64, where the rows begin that an action of several moves has passed.
        rewards: (longest action, LANES) float64, what it has earned there.
        known_codes, known_rows: int64 and int32, a hash table from observation codes to rows.
    """

    running: NDArray[np.int64]
    numbers: NDArray[np.uint64]
    reals: FloatArray
    values: FloatArray
    q: FloatArray
    entries: NDArray[np.uint32]
    passed: NDArray[np.uint64]
    rewards: FloatArray
    known_codes: NDArray[np.int64]
    known_rows: NDArray[np.int32]


def _aligned(shape: tuple[int, ...], dtype: type[np.generic]) -> NDArray[Any]:
    """Zeros that begin with a cache line, so that no row and no vector lies in more lines than it must."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    buffer = np.zeros(size + _CACHE_LINE, dtype=np.uint8)
    first = -buffer.ctypes.data % _CACHE_LINE
    return buffer[first : first + size].view(dtype).reshape(shape)


def empty_lanes(lanes: int, observations: int, lengths: tuple[int, ...]) -> Lanes:
    """Room for some periods, none of them running.

    Args:
        lanes: how many, at most `LANES`.
        observations: n_goals · cells, of a period.
        lengths: moves of every action length.
    """
    numbers = _aligned((COLUMNS * LANES,), np.uint64)
    numbers[int(HOME) : int(HOME) + LANES] = np.arange(LANES)
    n_actions, longest = 4 * len(lengths), max(lengths)
    # Half empty at least, so that looking up a code takes few steps.
    slots = 1 << (2 * observations - 1).bit_length()
    return Lanes(
        running=np.zeros(1, dtype=np.int64),
        numbers=numbers,
        reals=_aligned((REAL_COLUMNS * LANES,), np.float64),
        values=_aligned(((n_actions + 1) * LANES,), np.float64),
        q=_aligned((lanes, observations * n_actions), np.float64),
        entries=np.empty((lanes, observations), dtype=np.uint32),
        passed=np.empty((1 + longest, LANES), dtype=np.uint64),
        rewards=np.empty((longest, LANES)),
        known_codes=np.empty(slots, dtype=np.int64),
        known_rows=np.empty(slots, dtype=np.int32),
    )
