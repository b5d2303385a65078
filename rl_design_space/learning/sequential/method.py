"""What a point asks of the sequential kernel: learner, behaviour and step sizes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Kinds of behaviour, see `Behaviour`.
EPSILON_GREEDY, SOFTMAX, UPPER_BOUND = range(3)
#: Kinds of learners, see `Learner`.
GREATEST, NEXT, EXPECTED, DOUBLE, STEPS, TREE, REPLACING, ACCUMULATING, PLANNING, OWN = range(10)


class Learner(NamedTuple):
    """What is learned from a step.

    Attributes:
        kind: the target is the `GREATEST` value of the next observation, that of the `NEXT` action, the `EXPECTED` one,
            or one from a `DOUBLE` matrix; or it is that of several `STEPS`, or a `TREE` of them; or there are
            `REPLACING` or `ACCUMULATING` traces, or `PLANNING`; or an update function of the user's `OWN`.
        chooses_first: whether the next action is chosen before the update.
        number: of steps of a target, or of planning steps.
        trace_decay: λ.
        update: address of the user's compiled function.
        parameters: float64, of that function.
    """

    kind: int
    chooses_first: bool
    number: int
    trace_decay: float
    update: int
    parameters: FloatArray


class Behaviour(NamedTuple):
    """How actions are chosen.

    Attributes:
        kind: of behaviour: `EPSILON_GREEDY`, `SOFTMAX` or `UPPER_BOUND`.
        levels: (trials,) float64, its level by trial: ε, the temperature, or the weight of the bonus.
        rule: address of a compiled rule that gives the level of the next trial, see `closed_loop`; 0 for none.
        parameters: float64, of that rule.
    """

    kind: int
    levels: FloatArray
    rule: int
    parameters: FloatArray


class StepSizes(NamedTuple):
    """α: `alphas[trial]`, over N^power at the N-th update of an observation and action.

    Attributes:
        alphas: (trials,) float64.
        power: 0 if α does not depend on updates.
    """

    alphas: FloatArray
    power: float


class Path(NamedTuple):
    """The way of the agent in one trial of k steps, or in all trials, one after the other.

    Attributes:
        cells: (k + 1,) int32, from the start to the final goal, or to where the step cap ended the trial.
        counters: (k + 1,) int32, success counter in each of these states; the number of goals at the final goal.
        actions: (k,) int32, the action that each step belongs to.
        explored: (k,) bool, whether the action was an exploratory one.
    """

    cells: NDArray[np.int32]
    counters: NDArray[np.int32]
    actions: NDArray[np.int32]
    explored: NDArray[np.bool_]


class Notes(NamedTuple):
    """What is recorded of a period; arrays without elements are not.

    Attributes:
        trail: the paths of all trials, with a place for the end of each.
        q_after: (trials, rows, n_actions) float64, Q-matrix after each trial.
    """

    trail: Path
    q_after: FloatArray


class Method(NamedTuple):
    """What a point asks of the sequential kernel.

    Attributes:
        learner: what is learned from a step.
        behaviour: how actions are chosen.
        step_sizes: α.
        notes: what is recorded.
    """

    learner: Learner
    behaviour: Behaviour
    step_sizes: StepSizes
    notes: Notes


def no_notes() -> Notes:
    """Return notes that record nothing."""
    places = np.empty((3, 0), dtype=np.int32)
    trail = Path(places[0], places[1], places[2], np.empty(0, dtype=np.bool_))
    return Notes(trail, np.empty((0, 0, 0)))
