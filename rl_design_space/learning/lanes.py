"""Periods that are learned side by side, each in a lane of its own.

One period alone is slow: the next decision waits for the last update. Several periods have nothing to wait for from
each other, so the processor works on one lane while another waits, and draws random numbers and decides for four or
eight lanes with one instruction.

All numbers of all lanes lie in one array, column after column, a column having a place for every lane. That the
columns begin at constants is what lets the compiler see that writing one never changes another.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Lanes that there is room for: enough that nothing waits, few enough that the Q-matrices stay in the cache.
LANES = 16

# Indices are unsigned, so that no index has to be tested for being negative.
index = np.uint64

#: State of the random generator, its word of this turn, and ε · 2^32.
S0, S1, S2, S3, WORD, THRESHOLD = (index(column * LANES) for column in range(6))
#: The action chosen, where the row of the Q-matrix that is seen begins, the agent's cell, and where the entries of
#: the present success counter begin.
ACTION, ROW, CELL, STAGE = (index(column * LANES) for column in range(6, 10))
#: Moves made in this trial, its number, that of the period, and whose part of the tables the lane uses.
MOVES, TRIAL, PERIOD, HOME = (index(column * LANES) for column in range(10, 14))
COLUMNS = 14


class Lanes(NamedTuple):
    """What `learn` keeps of the periods in flight.

    Attributes:
        running: (1,) int64, lanes in use.
        numbers: (COLUMNS · LANES,) uint64, see the columns above.
        values: (n_actions · LANES,) float64, the Q-values that each lane's agent sees, a column for every action.
        q: (lanes, n_goals · cells · n_actions) float64, Q-matrices, by row and action.
        entries: (lanes, n_goals · cells) uint32, what a move onto a cell leads to, by success counter and cell: where
            in `q` the row begins that is seen there, a multiple of four, plus one of the four kinds of `kernel`.
        known_codes, known_rows: int64 and int32, a hash table from observation codes to rows.
    """

    running: NDArray[np.int64]
    numbers: NDArray[np.uint64]
    values: FloatArray
    q: FloatArray
    entries: NDArray[np.uint32]
    known_codes: NDArray[np.int64]
    known_rows: NDArray[np.int32]


def empty_lanes(lanes: int, observations: int, n_actions: int) -> Lanes:
    """Room for some periods, none of them running.

    Args:
        lanes: how many, at most `LANES`.
        observations: n_goals · cells, of a period.
        n_actions: columns of the Q-matrix.
    """
    numbers = np.zeros(COLUMNS * LANES, dtype=np.uint64)
    numbers[int(HOME) : int(HOME) + LANES] = np.arange(LANES)
    # Half empty at least, so that looking up a code takes few steps.
    slots = 1 << (2 * observations - 1).bit_length()
    return Lanes(
        running=np.zeros(1, dtype=np.int64),
        numbers=numbers,
        values=np.zeros(n_actions * LANES),
        q=np.empty((lanes, observations * n_actions)),
        entries=np.empty((lanes, observations), dtype=np.uint32),
        known_codes=np.empty(slots, dtype=np.int64),
        known_rows=np.empty(slots, dtype=np.int32),
    )
