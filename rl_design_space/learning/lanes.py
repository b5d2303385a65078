"""Lanes: periods that are learned side by side.

One period alone is slow, because each decision depends on the previous update. Periods are independent of each other,
so the processor works on one lane while another waits, and one instruction decides and updates for four or eight lanes.

The numbers of all lanes are stored column after column; a column has an element for every lane. Columns begin at
constant offsets, and a vectorised loop never writes to the array of Q-values that it reads: so the compiler can prove
that lanes are independent.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.numbering import slot_count

#: Maximum number of lanes: enough to hide all latencies, few enough that the Q-matrices stay in the cache. Not a power
#: of two, so that the columns do not compete for the same cache sets.
LANES = 24
#: Maximum bytes of the Q-matrices of all lanes of a thread, so that they stay in the cache of the processor; number of
#: lanes that are used even if they exceed it, because fewer would not hide latencies; maximum bytes for those.
_CACHED_BYTES, _ENOUGH_LANES, _LARGEST_BYTES = 2**22, 6, 2**28
#: Number of lanes that are rounded up to for vector instructions; up to `FEW` lanes are faster without them.
WIDTH, FEW = 8, 4

_CACHE_LINE = 64

# Indices are unsigned, so that no check for negative indices is compiled.
index = np.uint64

#: State of the random generator, its word of this iteration, and ε · 2^32.
S0, S1, S2, S3, WORD, THRESHOLD = (index(column * LANES) for column in range(6))
#: The chosen action, offset of the current row of the Q-matrix, the agent's cell, offset of the entries of the current
#: success counter, and the entry that the action has led to.
ACTION, ROW, CELL, STAGE, ENTRY = (index(column * LANES) for column in range(6, 11))
#: Number of steps that a multi-step action has made.
EXECUTED = index(11 * LANES)
#: Offset of the updated Q-value, its index in the current row (n_actions if it is in another row), and whether the
#: trial has ended.
UPDATED, SEEN, ENDED = (index(column * LANES) for column in range(12, 15))
#: Number of steps in this trial, number of the trial, number of the period, and number of the part of the tables that
#: the lane uses.
MOVES, TRIAL, PERIOD, HOME = (index(column * LANES) for column in range(15, 19))
#: Bits of the actions whose Q-values are the maximum of the current row, where there are multi-step actions.
MAXIMA = index(19 * LANES)
COLUMNS = 20

#: Q-value of the chosen action before and after its update; where there are multi-step actions, the return of the
#: chosen one, and the discount of the next state.
OLD, NEW, RETURN, DISCOUNT = (index(column * LANES) for column in range(4))
REAL_COLUMNS = 4

#: Kinds of cells that a step can lead to, the two low bits of an entry: no goal, a goal that is not due, the due
#: sub-goal, the due final goal.
PLAIN, OUT_OF_ORDER, SUB_GOAL, FINAL_GOAL = (index(kind) for kind in range(4))
KIND = index(3)


class Lanes(NamedTuple):
    """State of the periods that `learn` has begun and not ended.

    Attributes:
        running: (1,) int64, number of lanes in use.
        numbers: (COLUMNS · LANES,) uint64, see the columns above.
        reals: (REAL_COLUMNS · LANES,) float64, see the columns above.
        values: ((n_actions + 1) · LANES,) float64, the Q-values of each lane's current row, a column for every action,
            and one for values to discard. Where actions repeat several steps, the first column alone is used, for the
            maximum of the row that an action has led to.
        q: (lanes, n_goals · cells · width of a row) float64, Q-matrices, by row and action.
        entries: (lanes, n_goals · cells) uint32, what a step onto a cell leads to, by success counter and cell: the
            offset in `q` of the row of the observation there, a multiple of four, plus one of the four kinds.
        passed: (1 + longest action, LANES) uint64, offsets of the rows that a multi-step action has passed.
        rewards: (longest action, LANES) float64, rewards of its steps.
        made: (longest action, LANES) uint64, its steps, if they follow a table.
        controls: (lanes, n_goals · cells · width of a row) uint32, by row and action, if actions follow a table: the
            step that the action makes there, whether it stops on arriving, and what it perceives; see `action_tables`.
        earnings: (lanes, n_goals · cells · width · k) float64, rewards by state, step and outcome, see `chance.Pay`; no
            width if they depend on the kind of cell alone.
        went: (longest action, LANES) uint64, the cells that its steps have led to, if chance decides that.
        known_codes, known_rows: int64 and int32, a hash table from observation codes to rows.
        given: (periods, n_goals · cells · width of a row) float64, the Q-matrices that periods begin with, see
            `StagedLearning`. Without any, all values begin as `initial_q`.
        kept: (periods, n_goals · cells · width of a row) float64, those that periods end with, if a stage needs them;
            may be the same array.
        states: (periods, 4) uint64, the state of the random generator at their end, if a stage needs it.
    """

    running: NDArray[np.int64]
    numbers: NDArray[np.uint64]
    reals: FloatArray
    values: FloatArray
    q: FloatArray
    entries: NDArray[np.uint32]
    passed: NDArray[np.uint64]
    rewards: FloatArray
    made: NDArray[np.uint64]
    controls: NDArray[np.uint32]
    earnings: FloatArray
    went: NDArray[np.uint64]
    known_codes: NDArray[np.int64]
    known_rows: NDArray[np.int32]
    given: FloatArray
    kept: FloatArray
    states: NDArray[np.uint64]


def _aligned(shape: tuple[int, ...], dtype: type[np.generic]) -> NDArray[Any]:
    """Return zeros aligned to a cache line, so that rows and vectors touch as few lines as possible."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    buffer = np.zeros(size + _CACHE_LINE, dtype=np.uint8)
    first = -buffer.ctypes.data % _CACHE_LINE
    return buffer[first : first + size].view(dtype).reshape(shape)


@register_jitable
def row_width(n_actions: int) -> int:
    """Return the values that a row of the Q-matrix takes: a multiple of four, see `Lanes.entries`."""
    return (n_actions + 3) // 4 * 4


def side_by_side(periods: int, threads: int, bytes_each: int) -> int:
    """Return the number of lanes of each thread."""
    cached = min(LANES, _CACHED_BYTES // bytes_each)
    lanes = max(_ENOUGH_LANES, cached - cached % WIDTH)
    return max(1, min(lanes, _LARGEST_BYTES // bytes_each, -(-periods // threads)))


def empty_lanes(
    lanes: int,
    observations: int,
    limits: tuple[int, ...],
    *,
    tabulated: bool = False,
    drawn: bool = False,
    earnings: int = 0,
    given: FloatArray | None = None,
    kept: FloatArray | None = None,
    states: NDArray[np.uint64] | None = None,
) -> Lanes:
    """Return lanes of which none is running.

    Args:
        lanes: number of lanes, at most `LANES`.
        observations: n_goals · cells, of a period.
        limits: the most steps of each action.
        tabulated: whether actions follow a table.
        drawn: whether chance decides where steps lead.
        earnings: rewards by transition of a period, see `earning.earnings`; 0 if there are none.
        given: see `Lanes`; none if not given.
        kept: see `Lanes`; none if not given.
        states: see `Lanes`; none if not given.
    """
    numbers = _aligned((COLUMNS * LANES,), np.uint64)
    numbers[int(HOME) : int(HOME) + LANES] = np.arange(LANES)
    n_actions, longest, width = len(limits), max(limits), row_width(len(limits))
    slots = slot_count(observations)
    return Lanes(
        running=np.zeros(1, dtype=np.int64),
        numbers=numbers,
        reals=_aligned((REAL_COLUMNS * LANES,), np.float64),
        values=_aligned(((n_actions + 1) * LANES,), np.float64),
        q=_aligned((lanes, observations * width), np.float64),
        entries=np.empty((lanes, observations), dtype=np.uint32),
        passed=np.empty((1 + longest, LANES), dtype=np.uint64),
        rewards=np.empty((longest, LANES)),
        made=np.empty((longest * tabulated, LANES), dtype=np.uint64),
        controls=np.empty((lanes, observations * width * tabulated), dtype=np.uint32),
        earnings=np.empty((lanes, earnings)),
        went=np.empty((longest * drawn, LANES), dtype=np.uint64),
        known_codes=np.empty(slots, dtype=np.int64),
        known_rows=np.empty(slots, dtype=np.int32),
        given=np.empty((0, 0)) if given is None else given,
        kept=np.empty((0, 0)) if kept is None else kept,
        states=np.empty((0, 4), dtype=np.uint64) if states is None else states,
    )
