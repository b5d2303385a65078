"""What the learners do at each moment of a period, by their kinds."""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.compiled import compiled, inlined, uncounted
from rl_design_space.learning.lanes import index, row_width
from rl_design_space.learning.sequential.choosing import expected
from rl_design_space.learning.sequential.memory import count_update, greatest_of, step_size
from rl_design_space.learning.sequential.method import (
    ACCUMULATING,
    DOUBLE,
    EXPECTED,
    NEXT,
    OWN,
    PLANNING,
    REPLACING,
    STEPS,
    TREE,
)
from rl_design_space.learning.sequential.one_step import learn_double, learn_one_step
from rl_design_space.learning.sequential.own import call_address
from rl_design_space.learning.sequential.planning import plan
from rl_design_space.learning.sequential.several_steps import learn_several_steps
from rl_design_space.learning.sequential.traces import decay_traces, learn_with_traces


@compiled
def begin_learning(learner, memory, used):
    """Begin a period whose Q-matrix has so many entries in use."""
    kind = learner.kind
    if kind == DOUBLE:
        for entry in range(used):
            memory.other[entry] = memory.q[entry]
    elif kind == OWN:
        memory.other[:used] = 0.0
    elif kind == PLANNING:
        memory.taken[:used] = 0
        memory.size[0] = 0
    memory.updates[: min(used, len(memory.updates))] = 0
    memory.chosen[: min(used, len(memory.chosen))] = 0


@inlined
def begin_trial_of(learner, memory):
    """Begin a trial."""
    if learner.kind == REPLACING or learner.kind == ACCUMULATING:
        decay_traces(memory, 0.0)


@inlined
def show(learner, memory, row, n_actions):
    """Enter the Q-values of a row, as the behaviour sees them, in `memory.values`."""
    for action in range(n_actions):
        value = memory.q[row + index(action)]
        if learner.kind == DOUBLE:
            value = 0.5 * (value + memory.other[row + index(action)])
        memory.values[action] = value


@inlined
def learn_from_step(
    learner, memory, kind, level, rules, n_actions, alpha, power, time, row, action, gain, next_row, next_action,
    terminal, ended,
):  # fmt: skip
    """Learn from a step; return its error, the difference that α multiplies.

    Args:
        learner: see `method.Learner`.
        memory: see `Memory`.
        kind: of behaviour, see `choose_action`.
        level: see `choose_action`.
        rules: see `kernel.Rules`.
        n_actions: number of actions.
        alpha: α before it is divided, see `StepSizes`.
        power: see `StepSizes`.
        time: number of the step in the trial, from 0.
        row: offset of the row of the observation.
        action: the action taken there.
        gain: the reward.
        next_row: offset of the row of the next observation.
        next_action: the action chosen there, if the learner chooses first.
        terminal: whether the step has reached the final goal.
        ended: whether the trial ends, there or at the step cap.
    """
    if learner.kind == STEPS or learner.kind == TREE:
        return learn_several_steps(
            learner, memory, kind, level, rules, n_actions, alpha, power, time, row, action, gain, next_row,
            next_action, terminal, ended,
        )  # fmt: skip
    entry = row + action
    if learner.kind == DOUBLE:
        return learn_double(memory, rules, n_actions, alpha, power, entry, gain, next_row, terminal)
    if learner.kind == OWN:
        return _learn_by_own(
            learner, memory, rules, n_actions, alpha, power, row, action, gain, next_row, next_action, terminal
        )
    value = 0.0
    if not terminal:
        if learner.kind == NEXT:
            value = memory.q[next_row + next_action]
        elif learner.kind == EXPECTED:
            show(learner, memory, next_row, n_actions)
            value = expected(
                kind, level, memory.values, memory.chosen, next_row, n_actions, rules, memory.scratch,
                memory.probabilities,
            )  # fmt: skip
        else:
            value = greatest_of(memory.q, next_row, n_actions)
    if learner.kind == REPLACING or learner.kind == ACCUMULATING:
        return learn_with_traces(learner, memory, rules, alpha, power, entry, gain, value)
    error = learn_one_step(memory.q, memory.updates, rules, alpha, power, entry, gain, value)
    if learner.kind == PLANNING:
        plan(learner, memory, rules, n_actions, alpha, power, row, action, gain, next_row, terminal)
    return error


@uncounted
def _learn_by_own(
    learner, memory, rules, n_actions, alpha, power, row, action, gain, next_row, next_action, terminal
):  # fmt: skip
    """Learn by the user's update function; return the error that it returns."""
    width = row_width(n_actions)
    count_update(memory.updates, power, row + action)
    alpha = step_size(alpha, memory.updates, power, row + action)
    arrays = np.int64(memory.q.ctypes.data), np.int64(memory.other.ctypes.data)
    shape = np.int64(len(memory.q) // width), np.int64(width), np.int64(n_actions)
    step = np.int64(row) // width, np.int64(action), np.int64(next_row) // width, np.int64(next_action)
    parameters = np.int64(learner.parameters.ctypes.data), np.int64(len(learner.parameters))
    return call_address(
        learner.update, arrays + shape + step + (np.int64(terminal), gain, alpha, rules.gamma) + parameters
    )


@inlined
def after_choice(learner, memory, rules, is_greedy):
    """Take note that the action chosen next is greedy or not."""
    if learner.kind == REPLACING or learner.kind == ACCUMULATING:
        decay_traces(memory, rules.gamma * learner.trace_decay if is_greedy else 0.0)


@uncounted
def end_learning(learner, memory, used):
    """End a period: what has been learned is to be in the Q-matrix."""
    if learner.kind == DOUBLE:
        for entry in range(used):
            memory.q[entry] = 0.5 * (memory.q[entry] + memory.other[entry])
