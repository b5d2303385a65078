"""Targets of several steps: n-step Sarsa and tree backup. What was passed last is kept in a ring."""

from __future__ import annotations

from rl_design_space.learning.compiled import uncounted
from rl_design_space.learning.lanes import index
from rl_design_space.learning.sequential.choosing import expected
from rl_design_space.learning.sequential.memory import count_update, step_size
from rl_design_space.learning.sequential.method import TREE


@uncounted
def learn_several_steps(
    learner, memory, kind, level, rules, n_actions, alpha, power, time, row, action, gain, next_row, next_action,
    terminal, ended,
):  # fmt: skip
    """Learn the value of the action of n steps ago, and at the end of a trial of all that follow it.

    Returns:
        The error of the last of them; 0 if none learns.
    """
    q, passed, gains = memory.q, memory.places, memory.gains
    ring = len(passed)
    passed[time % ring], gains[time % ring] = row + action, gain
    first = time - learner.number + 1
    last = time if ended else first
    error = 0.0
    for began in range(max(first, 0), last + 1):
        if learner.kind == TREE:
            value = 0.0
            if not terminal:
                value = _mean(memory, kind, level, rules, n_actions, next_row)
            target = gain + rules.gamma * value
            for at in range(time, began, -1):
                entry = passed[at % ring]
                taken = entry % index(_width(n_actions))
                mean = _mean(memory, kind, level, rules, n_actions, entry - taken)
                share = memory.probabilities[taken]
                target = gains[(at - 1) % ring] + rules.gamma * (mean + share * (target - q[entry]))
        else:
            target, discount = 0.0, 1.0
            for at in range(began, time + 1):
                target += discount * gains[at % ring]
                discount *= rules.gamma
            if not terminal:
                target += discount * q[next_row + next_action]
        entry = passed[began % ring]
        count_update(memory.updates, power, entry)
        error = target - q[entry]
        q[entry] += step_size(alpha, memory.updates, power, entry) * error
    return error


@uncounted
def _width(n_actions):
    return (n_actions + 3) // 4 * 4


@uncounted
def _mean(memory, kind, level, rules, n_actions, row):
    """Return the mean value of a row under the behaviour; its probabilities are in `memory`."""
    for action in range(n_actions):
        memory.values[action] = memory.q[row + index(action)]
    return expected(
        kind, level, memory.values, memory.chosen, row, n_actions, rules, memory.scratch, memory.probabilities
    )
