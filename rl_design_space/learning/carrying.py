"""Carrying Q-values from the stages of a period to the next one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import World, cell_count
from rl_design_space.learning.compiled import compiled_and_kept
from rl_design_space.learning.numbering import bits_of, numbered, slot_count, slot_of
from rl_design_space.learning.stage_layouts import place_of


class StageScene(NamedTuple):
    """A stage as carry rules see it, see `design.Scene`."""

    world: World
    goals: NDArray[np.int32]
    codes: NDArray[np.int64]


class Memory(NamedTuple):
    """Values of all observations that periods have met, also of those that do not occur in the last stage.

    Attributes:
        count: (periods,) int64, number of observations.
        known_codes, known_rows: (periods, slots) int64 and int32, hash tables from their codes to rows of values.
        values: (periods, rows · n_actions) float64.
    """

    count: NDArray[np.int64]
    known_codes: NDArray[np.int64]
    known_rows: NDArray[np.int32]
    values: FloatArray


def empty_memory(periods: int, observations: int, n_actions: int) -> Memory:
    """Return the memory of periods that have met nothing.

    Args:
        periods: number of periods.
        observations: the most that each of them will meet.
        n_actions: number of actions.
    """
    slots = slot_count(observations)
    return Memory(
        np.zeros(periods, dtype=np.int64),
        np.empty((periods, slots), dtype=np.int64),
        np.full((periods, slots), -1, dtype=np.int32),
        np.empty((periods, observations * n_actions)),
    )


@compiled_and_kept
def remember(memory, codes, kept, n_actions):
    """Put the values of a stage into the memory.

    Args:
        memory: see `Memory`; modified in place.
        codes: (periods, n_goals, cells) int64, observation codes of the stage.
        kept: (periods, n_goals · cells · n_actions) float64, its Q-matrices, see `Lanes`.
        n_actions: number of actions.
    """
    for period in range(len(codes)):
        states = codes[period].ravel()
        known_codes, known_rows, values = memory.known_codes[period], memory.known_rows[period], memory.values[period]
        bits = bits_of(known_rows)
        row_of = np.empty(len(states), dtype=np.int64)
        own_codes = np.empty(len(known_codes), dtype=np.int64)
        own_rows = np.empty(len(known_rows), dtype=np.int32)
        numbered(states, own_codes, own_rows, row_of)
        following = 0
        for state in range(len(states)):
            row = row_of[state]
            if row < following:
                continue
            following += 1
            slot = slot_of(states[state], known_codes, known_rows, bits)
            if known_rows[slot] < 0:
                known_rows[slot] = memory.count[period]
                known_codes[slot] = states[state]
                memory.count[period] += 1
            at = known_rows[slot] * n_actions
            for action in range(n_actions):
                values[at + action] = kept[period, row * n_actions + action]


@compiled_and_kept
def recall(memory, first, codes, initial_q, n_actions, kept, carried):
    """Begin Q-matrices with the values that the memory has of their observations.

    Args:
        memory: see `Memory`.
        first: number of the first of these periods.
        codes: (taken, n_goals, cells) int64, observation codes of the stage that begins.
        initial_q: value of what is not in the memory.
        n_actions: number of actions.
        kept: (periods, n_goals · cells · n_actions) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows that the memory had.
    """
    for taken in range(len(codes)):
        period, states = first + taken, codes[taken].ravel()
        known_codes, known_rows, values = memory.known_codes[period], memory.known_rows[period], memory.values[period]
        bits = bits_of(known_rows)
        slots = 1
        while slots < 2 * len(states):
            slots *= 2
        row_of = np.empty(len(states), dtype=np.int64)
        numbered(states, np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int32), row_of)
        following = found = 0
        for state in range(len(states)):
            row = row_of[state]
            if row < following:
                continue
            following += 1
            at = known_rows[slot_of(states[state], known_codes, known_rows, bits)] * n_actions
            found += at >= 0
            for action in range(n_actions):
                kept[period, row * n_actions + action] = values[at + action] if at >= 0 else initial_q
        carried[period] = found


@compiled_and_kept
def inherit(ancestors, codes_before, kept_before, first, codes, initial_q, n_actions, kept, carried):
    """Begin Q-matrices with the values of their states' ancestors: a row with the mean over those of its states.

    The mean is a running one, in the order of states: of equal values it is exactly that value.

    Args:
        ancestors: (taken, n_goals, cells) int64, of each state one of the stage before, or -1.
        codes_before: (periods, n_goals, cells before) int64, observation codes of the stage before.
        kept_before: (periods, n_goals · cells before · n_actions) float64, its Q-matrices.
        first: number of the first of these periods.
        codes: (taken, n_goals, cells) int64, observation codes of the stage that begins.
        initial_q: value of what has no ancestor.
        n_actions: number of actions.
        kept: (periods, n_goals · cells · n_actions) float64, output: Q-matrices, see `Lanes`.
        carried: (periods,) int32, output: number of rows with an ancestor.
    """
    for taken in range(len(codes)):
        period, states, ancestor_of = first + taken, codes[taken].ravel(), ancestors[taken].ravel()
        before = codes_before[period].ravel()
        slots = 1
        while slots < 2 * max(len(states), len(before)):
            slots *= 2
        known_codes, known_rows = np.empty(slots, dtype=np.int64), np.empty(slots, dtype=np.int32)
        row_of, row_before = np.empty(len(states), dtype=np.int64), np.empty(len(before), dtype=np.int64)
        numbered(before, known_codes, known_rows, row_before)
        n_rows = numbered(states, known_codes, known_rows, row_of)
        counts = np.zeros(n_rows, dtype=np.int64)
        kept[period, : n_rows * n_actions] = initial_q
        found = 0
        for state in range(len(states)):
            ancestor, row = ancestor_of[state], row_of[state]
            if ancestor < 0:
                continue
            counts[row] += 1
            found += counts[row] == 1
            for action in range(n_actions):
                value = kept_before[period, row_before[ancestor] * n_actions + action]
                mean = kept[period, row * n_actions + action]
                at = row * n_actions + action
                kept[period, at] = value if counts[row] == 1 else mean + (value - mean) / counts[row]
        carried[period] = found


def same_place(before: StageScene, after: StageScene) -> NDArray[np.int64]:
    """Return the ancestors of states: equal success counter, and the cell at the same place of the grid before."""
    counter = np.arange(after.goals.shape[1], dtype=np.int64)[:, np.newaxis]
    ancestors = counter * cell_count(before.world) + place_of(after.world, before.world)
    return np.ascontiguousarray(np.broadcast_to(ancestors, after.codes.shape))
