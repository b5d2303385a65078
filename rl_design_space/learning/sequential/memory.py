"""What an agent of the sequential kernel works with, and the steps that all learners share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.compiled import compiled, inlined
from rl_design_space.learning.lanes import index
from rl_design_space.learning.sequential.elementary import to_the_minus
from rl_design_space.learning.sequential.method import (
    ACCUMULATING,
    DOUBLE,
    OWN,
    PLANNING,
    REPLACING,
    STEPS,
    TREE,
    UPPER_BOUND,
)


class Memory(NamedTuple):
    """Arrays of one agent; those by entry are indexed as the Q-matrix is, `row + action`.

    Arrays that a learner or behaviour has no use for have a single element.

    Attributes:
        random: the random generator, see `lanes`.
        q: (entries,) float64, the Q-matrix.
        other: (entries,) float64, of the learner: a second Q-matrix, traces, rewards of a model, or what it likes.
        places: uint64, of the learner: entries with a trace; next rows of a model, by entry; entries passed.
        rows_met: uint64, of the learner: rows that a model knows.
        taken: uint64, of the learner: for each row the set of actions that a model knows there.
        size: (1,) int64, of the learner: number of entries with a trace, or of rows that a model knows.
        gains: float64, rewards of the steps of a target.
        updates: (entries,) uint32, number of updates.
        chosen: (entries,) uint32, how often the action was chosen.
        values: (n_actions,) float64, Q-values of the agent's row, as the behaviour sees them.
        probabilities: (n_actions,) float64.
        scratch: (n_actions,) float64.
    """

    random: NDArray[np.uint64]
    q: FloatArray
    other: FloatArray
    places: NDArray[np.uint64]
    rows_met: NDArray[np.uint64]
    taken: NDArray[np.uint64]
    size: NDArray[np.int64]
    gains: FloatArray
    updates: NDArray[np.uint32]
    chosen: NDArray[np.uint32]
    values: FloatArray
    probabilities: FloatArray
    scratch: FloatArray


@compiled
def new_memory(random, q, method, n_actions):
    """Return the memory of an agent with this generator and Q-matrix."""
    learner = method.learner
    entries, kind = len(q), learner.kind
    traces = kind in (REPLACING, ACCUMULATING)
    steps = learner.number + 1 if kind in (STEPS, TREE) else 1
    return Memory(
        random,
        q,
        np.zeros(entries if traces or kind in (DOUBLE, PLANNING, OWN) else 1),
        np.zeros(entries if traces or kind == PLANNING else steps, dtype=np.uint64),
        np.zeros(entries if kind == PLANNING else 1, dtype=np.uint64),
        np.zeros(entries if kind == PLANNING else 1, dtype=np.uint64),
        np.zeros(1, dtype=np.int64),
        np.zeros(steps),
        np.zeros(entries if method.step_sizes.power != 0.0 else 1, dtype=np.uint32),
        np.zeros(entries if method.behaviour.kind == UPPER_BOUND else 1, dtype=np.uint32),
        np.zeros(n_actions),
        np.zeros(n_actions),
        np.zeros(n_actions),
    )


@inlined
def greatest_of(q, row, n_actions):
    """Return the maximum of a row of a Q-matrix."""
    best = q[row]
    for action in range(1, n_actions):
        value = q[row + index(action)]
        best = value if value > best else best
    return best


@inlined
def count_update(updates, power, entry):
    """Count an update of an entry, if α depends on it."""
    if power != 0.0:
        updates[entry] += 1


@inlined
def step_size(alpha, updates, power, entry):
    """Return α for an entry; its update is counted already."""
    return alpha if power == 0.0 else alpha * to_the_minus(updates[entry], power)
