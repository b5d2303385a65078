"""Carrying Q-values from the stages of a period to the next one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import Scene, cell_count
from rl_design_space.learning.compiled import compiled_and_kept
from rl_design_space.learning.numbering import bits_of, numbered, slot_count, slot_of
from rl_design_space.learning.stage_layouts import place_of


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


@compiled_and_kept
def number_rows(codes, rows):
    """Number the rows of Q-matrices as the kernel does, in the order in which their codes first occur.

    Args:
        codes: (periods, n_goals, cells) int64, observation codes.
        rows: (periods, n_goals, cells) int64, output: the row of each state.
    """
    slots = 1
    while slots < 2 * codes.shape[1] * codes.shape[2]:
        slots *= 2
    known_codes, known_rows = np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int32)
    for period in range(len(codes)):
        numbered(codes[period].ravel(), known_codes, known_rows, rows[period].ravel())


@compiled_and_kept
def remember(memory, codes, rows, kept, width):
    """Put the values of a stage into the memory.

    Args:
        memory: see `Memory`; modified in place.
        codes: (periods, n_goals, cells) int64, observation codes of the stage.
        rows: (periods, n_goals, cells) int64, the row of each state.
        kept: (periods, n_goals · cells · width) float64, its Q-matrices, see `Lanes`.
        width: values of a row, see `row_width`.
    """
    for period in range(len(codes)):
        states, row_of = codes[period].ravel(), rows[period].ravel()
        known_codes, known_rows, values = memory.known_codes[period], memory.known_rows[period], memory.values[period]
        bits = bits_of(known_rows)
        following = 0
        for state in range(len(states)):
            row = row_of[state]
            if row < following:
                continue
            following += 1
            slot = slot_of(states[state], known_codes, known_rows, bits)
            if known_rows[slot] < 0:
                known_rows[slot] = memory.met[period]
                known_codes[slot] = states[state]
                memory.met[period] += 1
            at = np.int64(known_rows[slot]) * width
            for action in range(width):
                values[at + action] = kept[period, row * width + action]


@compiled_and_kept
def recall(memory, codes, rows, initial_q, width, kept, carried):
    """Begin Q-matrices with the values that the memory has of their observations.

    Args:
        memory: see `Memory`.
        codes: (periods, n_goals, cells) int64, observation codes of the stage that begins.
        rows: (periods, n_goals, cells) int64, the row of each state.
        initial_q: value of what is not in the memory.
        width: values of a row, see `row_width`.
        kept: (periods, n_goals · cells · width) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows that the memory had.
    """
    for period in range(len(codes)):
        states, row_of = codes[period].ravel(), rows[period].ravel()
        known_codes, known_rows, values = memory.known_codes[period], memory.known_rows[period], memory.values[period]
        bits = bits_of(known_rows)
        following = found = 0
        for state in range(len(states)):
            row = row_of[state]
            if row < following:
                continue
            following += 1
            at = np.int64(known_rows[slot_of(states[state], known_codes, known_rows, bits)]) * width
            found += at >= 0
            for action in range(width):
                kept[period, row * width + action] = values[at + action] if at >= 0 else initial_q
        carried[period] = found


@compiled_and_kept
def inherit(ancestors, first, rows_before, kept_before, rows, initial_q, width, kept, carried):
    """Begin Q-matrices with the values of their states' ancestors: a row with the mean over those of its states.

    The mean is a running one, in the order of states: of equal values it is exactly that value.

    Args:
        ancestors: (taken, n_goals, cells) int64, of each state one of the stage before, or -1.
        first: number of the first of these periods.
        rows_before: (periods, n_goals, cells before) int64, rows of the stage before.
        kept_before: (periods, n_goals · cells before · width) float64, its Q-matrices.
        rows: (periods, n_goals, cells) int64, rows of the stage that begins.
        initial_q: value of what has no ancestor.
        width: values of a row, see `row_width`.
        kept: (periods, n_goals · cells · width) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows with an ancestor.
    """
    counts = np.empty(rows.shape[1] * rows.shape[2], dtype=np.int64)
    for taken in range(len(ancestors)):
        period, ancestor_of = first + taken, ancestors[taken].ravel()
        row_of, row_before = rows[period].ravel(), rows_before[period].ravel()
        counts[:] = 0
        kept[period] = initial_q
        found = 0
        for state in range(len(row_of)):
            ancestor, row = ancestor_of[state], row_of[state]
            if ancestor < 0:
                continue
            counts[row] += 1
            found += counts[row] == 1
            for action in range(width):
                at = row * width + action
                value = kept_before[period, row_before[ancestor] * width + action]
                mean = value if counts[row] == 1 else kept[period, at]
                kept[period, at] = mean + (value - mean) / counts[row]
        carried[period] = found


def same_place(before: Scene, after: Scene) -> NDArray[np.int64]:
    """Return the ancestors of states: equal success counter, and the cell at the same place of the grid before."""
    counter = np.arange(after.goals.shape[1], dtype=np.int64)[:, np.newaxis]
    ancestors = counter * cell_count(before.world) + place_of(after.world, before.world)
    return np.ascontiguousarray(np.broadcast_to(ancestors, after.codes.shape))
