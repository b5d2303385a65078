"""Targets of one reward and a value of the next observation: Q-learning, Sarsa, expected Sarsa, double Q-learning."""

from __future__ import annotations

from rl_design_space.learning.behaviour import draw
from rl_design_space.learning.compiled import inlined, uncounted
from rl_design_space.learning.lanes import WORD, index
from rl_design_space.learning.sequential.choosing import pick_greatest
from rl_design_space.learning.sequential.memory import count_update, step_size

_63 = index(63)
_LOW = index(0xFFFFFFFF)


@inlined
def learn_one_step(q, updates, rules, alpha, power, entry, gain, value):
    """Learn from a reward and the value of the next observation; return the error."""
    count_update(updates, power, entry)
    old = q[entry]
    error = gain + rules.gamma * (value - old) if rules.printed_update else gain + rules.gamma * value - old
    q[entry] = old + step_size(alpha, updates, power, entry) * error
    return error


@uncounted
def learn_double(memory, rules, n_actions, alpha, power, entry, gain, next_row, terminal):
    """Learn as double Q-learning does; return the error.

    One word tosses the coin, and selects one of equal maxima.
    """
    count_update(memory.updates, power, entry)
    draw(memory.random, 1)
    word = memory.random[WORD]
    first = word >> _63 != 0
    value = 0.0
    if not terminal:
        for action in range(n_actions):
            at = next_row + index(action)
            memory.scratch[action] = memory.q[at] if first else memory.other[at]
        best, _ = pick_greatest(memory.scratch, n_actions, rules.first_maximum, word & _LOW)
        value = memory.other[next_row + best] if first else memory.q[next_row + best]
    old = memory.q[entry] if first else memory.other[entry]
    error = gain + rules.gamma * value - old
    new = old + step_size(alpha, memory.updates, power, entry) * error
    if first:
        memory.q[entry] = new
    else:
        memory.other[entry] = new
    return error
