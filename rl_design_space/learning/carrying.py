"""Carrying Q-values from the stages of a period to the next one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import World, cell_count
from rl_design_space.learning.compiled import compiled, compiled_and_kept
from rl_design_space.learning.lanes import index
from rl_design_space.learning.numbering import bits_of, numbered, slot_count, slot_of
from rl_design_space.learning.stage_layouts import place_of

# Indices are unsigned, so that no check for negative ones is compiled.
_0, _1, _2, _3 = (index(number) for number in range(4))


class Memory(NamedTuple):
    """Values of all observations that periods have met, also of those that do not occur in the last stage.

    Attributes:
        met: (periods,) int64, number of observations.
        known_codes, known_rows: (periods, slots) int64 and int32, hash tables from their codes to rows of values.
        values: (periods, rows · width) float64.
    """

    met: NDArray[np.int64]
    known_codes: NDArray[np.int64]
    known_rows: NDArray[np.int32]
    values: FloatArray


def empty_memory(periods: int, observations: int, width: int) -> Memory:
    """Return the memory of periods that have met nothing.

    Args:
        periods: number of periods.
        observations: the most that each of them will meet.
        width: values of a row, see `row_width`.
    """
    slots = slot_count(observations)
    return Memory(
        np.zeros(periods, dtype=np.int64),
        np.empty((periods, slots), dtype=np.int64),
        np.full((periods, slots), -1, dtype=np.int32),
        np.empty((periods, observations * width)),
    )


@compiled
def _copy_row(values, begin, source, begin_source, width):
    """Copy a row of values, four at a time; its width is a multiple of four."""
    for at in range(_0, width, index(4)):
        to, out_of = begin + at, begin_source + at
        one, two, three, four = source[out_of], source[out_of + _1], source[out_of + _2], source[out_of + _3]
        values[to], values[to + _1], values[to + _2], values[to + _3] = one, two, three, four


@compiled
def _equal(some, others):
    for at in range(len(some)):  # noqa: SIM110 (generators are not compiled)
        if some[at] != others[at]:
            return False
    return True


@compiled
def _all_equal(codes):
    for period in range(1, len(codes)):  # noqa: SIM110 (generators are not compiled)
        if not _equal(codes[period].ravel(), codes[0].ravel()):
            return False
    return True


@compiled_and_kept
def number_rows(codes, rows):
    """Number the rows of Q-matrices as the kernel does, in the order in which their codes first occur.

    Args:
        codes: (periods, n_goals, cells) int64, observation codes.
        rows: (periods, n_goals, cells) int64, output: the row of each state.

    Returns:
        How many periods were numbered: 1 if all have equal codes, so equal rows, else all.
    """
    slots = 1
    while slots < 2 * codes.shape[1] * codes.shape[2]:
        slots *= 2
    known_codes, known_rows = np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int32)
    taken = min(1, len(codes)) if _all_equal(codes) else len(codes)
    for period in range(taken):
        if period > 0 and _equal(codes[period].ravel(), codes[period - 1].ravel()):
            # Numba compiles the assignment of a whole array, with the message of its error, in five seconds.
            row_of, before = rows[period].ravel(), rows[period - 1].ravel()
            for state in range(len(row_of)):
                row_of[state] = before[state]
        else:
            numbered(codes[period].ravel(), known_codes, known_rows, rows[period].ravel())
    return taken


@compiled
def _remember(memory, at, states, row_of, kept, width):
    """Put the values of a stage of one period into the memory, as period `at` of it."""
    known_codes, known_rows, values = memory.known_codes[at], memory.known_rows[at], memory.values[at]
    bits = bits_of(known_rows)
    following = 0
    for state in range(len(states)):
        row = row_of[state]
        if row < following:
            continue
        following += 1
        slot = slot_of(states[state], known_codes, known_rows, bits)
        if known_rows[slot] < 0:
            known_rows[slot] = memory.met[at]
            known_codes[slot] = states[state]
            memory.met[at] += 1
        begin = np.int64(known_rows[slot]) * width
        _copy_row(values, index(begin), kept, index(row * width), index(width))


@compiled
def _recall(memory, at, states, row_of, initial_q, width, kept):
    """Begin a Q-matrix with the values that period `at` of the memory has; return of how many rows."""
    known_codes, known_rows, values = memory.known_codes[at], memory.known_rows[at], memory.values[at]
    bits = bits_of(known_rows)
    following = found = 0
    for state in range(len(states)):
        row = row_of[state]
        if row < following:
            continue
        following += 1
        begin = np.int64(known_rows[slot_of(states[state], known_codes, known_rows, bits)]) * width
        found += begin >= 0
        if begin >= 0:
            _copy_row(kept, index(row * width), values, index(begin), index(width))
        else:
            kept[row * width : (row + 1) * width] = initial_q
    return found


@compiled_and_kept
def carry_over(memory, anew, codes_before, rows_before, kept_before, codes, rows, initial_q, width, kept, carried):
    """Put the values of a stage into the memory, and begin the next one with what the memory has.

    Args:
        memory: see `Memory`; modified in place.
        anew: whether the memory is that of a single period, which every period begins anew, because no later stage
            needs it; so it stays in the cache.
        codes_before: (periods, n_goals, cells before) int64, observation codes of the stage before.
        rows_before: (periods, n_goals, cells before) int64, the row of each of its states; or (1, n_goals, cells
            before), the same in all periods.
        kept_before: (periods, n_goals · cells before · width) float64, its Q-matrices, see `Lanes`.
        codes: (periods, n_goals, cells) int64, observation codes of the stage that begins.
        rows: (periods, n_goals, cells) int64, the row of each state; or one period, as before.
        initial_q: value of what is not in the memory.
        width: values of a row, see `row_width`.
        kept: (periods, n_goals · cells · width) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows that the memory had.
    """
    for period in range(len(codes)):
        at = 0 if anew else period
        if anew:
            memory.met[0] = 0
            memory.known_rows[0] = -1
        row_before = rows_before[period % len(rows_before)].ravel()
        _remember(memory, at, codes_before[period].ravel(), row_before, kept_before[period], width)
        row_of = rows[period % len(rows)].ravel()
        carried[period] = _recall(memory, at, codes[period].ravel(), row_of, initial_q, width, kept[period])


@compiled_and_kept
def inherit(ancestors, first, taken, rows_before, kept_before, rows, initial_q, width, kept, carried):
    """Begin Q-matrices with the values of their states' ancestors: a row with the mean over those of its states.

    The mean is a running one, in the order of states: of equal values it is exactly that value.

    Args:
        ancestors: (taken, n_goals, cells) int64, of each state one of the stage before, or -1; or (1, n_goals, cells),
            the same in all periods.
        first: number of the first of the periods.
        taken: number of periods.
        rows_before: (periods, n_goals, cells before) int64, rows of the stage before; or (1, n_goals, cells before),
            the same in all periods.
        kept_before: (periods, n_goals · cells before · width) float64, its Q-matrices.
        rows: (periods, n_goals, cells) int64, rows of the stage that begins; or one period, as before.
        initial_q: value of what has no ancestor.
        width: values of a row, see `row_width`.
        kept: (periods, n_goals · cells · width) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows with an ancestor.
    """
    counts = np.empty(rows.shape[1] * rows.shape[2], dtype=np.int64)
    wide = index(width)
    for period in range(first, first + taken):
        ancestor_of = ancestors[(period - first) % len(ancestors)].ravel()
        row_of, row_before = rows[period % len(rows)].ravel(), rows_before[period % len(rows_before)].ravel()
        values, values_before = kept[period], kept_before[period]
        following = found = 0
        for state in range(len(row_of)):
            ancestor, row = ancestor_of[state], index(row_of[state])
            begin = row * wide
            if row_of[state] == following:
                following += 1
                counts[row] = 0
                if ancestor < 0:
                    values[begin : begin + wide] = initial_q
            if ancestor < 0:
                continue
            count = counts[row] + 1
            counts[row] = count
            begin_before = index(row_before[index(ancestor)]) * wide
            if count == 1:
                found += 1
                _copy_row(values, begin, values_before, begin_before, wide)
            else:
                for action in range(wide):
                    mean, value = values[begin + action], values_before[begin_before + action]
                    values[begin + action] = mean + (value - mean) / count
        carried[period] = found


def same_place(before: World, after: World, n_goals: int) -> NDArray[np.int64]:
    """Return the ancestors of states: equal success counter, and the cell at the same place of the grid before.

    Returns:
        (1, n_goals, cells) int64, the same in all periods.
    """
    counter = np.arange(n_goals, dtype=np.int64)[:, np.newaxis]
    return (counter * cell_count(before) + place_of(after, before))[np.newaxis]
