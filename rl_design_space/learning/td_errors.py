"""Collecting TD errors by state, which say whether cells that share values agree."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.compiled import compiled, inlined
from rl_design_space.learning.lanes import ACTION, CELL, HOME, LANES, NEW, OLD, PERIOD, STAGE, index


class Errors(NamedTuple):
    """TD errors of the actions that agents have executed; those of other actions that learn, too, are not among them.

    Attributes:
        sums: (periods, n_goals · cells, n_actions) float64, sums of α · TD error, the change of the Q-value, by the
            state in which the action began.
        counts: the same shape, int32, how many there were.
    """

    sums: FloatArray
    counts: NDArray[np.int32]


def no_errors(periods: int, states: int, n_actions: int) -> Errors:
    """Return sums of no errors."""
    shape = (periods, states, n_actions)
    return Errors(np.zeros(shape), np.zeros(shape, dtype=np.int32))


@compiled
def places_for_states(errors):
    """Return the places that `note_states` writes to; none if no errors are collected."""
    return np.empty(0 if errors is None else LANES, dtype=np.int64)


@inlined
def note_states(numbers, begun, running, observations):
    """Note the states in which agents begin an action.

    Args:
        numbers: see `Lanes`.
        begun: (lanes,) int64, output: counter · cells + cell.
        running: number of lanes in use.
        observations: n_goals · cells.
    """
    for lane in range(running):
        at = index(lane)
        stage = np.int64(numbers[STAGE + at]) - np.int64(numbers[HOME + at] * observations)
        begun[lane] = stage + np.int64(numbers[CELL + at])


@inlined
def add_errors(numbers, reals, begun, errors, running):
    """Add the errors of the actions that agents have executed; `errors` is modified in place."""
    for lane in range(running):
        at = index(lane)
        period, action = np.int64(numbers[PERIOD + at]), np.int64(numbers[ACTION + at])
        errors.sums[period, begun[lane], action] += reals[NEW + at] - reals[OLD + at]
        errors.counts[period, begun[lane], action] += 1
