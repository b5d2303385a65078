"""Dyna-Q: a model of what followed each observation and action last, and steps that learn from it."""

from __future__ import annotations

from rl_design_space.learning.behaviour import draw
from rl_design_space.learning.compiled import uncounted
from rl_design_space.learning.lanes import WORD, index
from rl_design_space.learning.sequential.memory import greatest_of
from rl_design_space.learning.sequential.one_step import learn_one_step

_0, _1, _32 = index(0), index(1), index(32)
_LOW = index(0xFFFFFFFF)


@uncounted
def plan(learner, memory, rules, n_actions, alpha, power, row, action, gain, next_row, terminal):
    """Enter a step in the model, and learn from the model.

    The upper half of a word selects a row that was met, the lower half an action that was taken there.
    """
    gains, following, met, taken, known_rows = memory.other, memory.places, memory.rows_met, memory.taken, memory.size
    if taken[row] == _0:
        met[known_rows[0]] = row
        known_rows[0] += 1
    taken[row] |= _1 << action
    # Rows are multiples of four.
    gains[row + action], following[row + action] = gain, next_row | index(terminal)
    for _ in range(learner.number):
        draw(memory.random, 1)
        word = memory.random[WORD]
        begun = met[((word >> _32) * index(known_rows[0])) >> _32]
        known = _0
        for each in range(n_actions):
            known += (taken[begun] >> index(each)) & _1
        left = ((word & _LOW) * known) >> _32
        chosen = _0
        for each in range(n_actions):
            if (taken[begun] >> index(each)) & _1:
                if left == _0:
                    chosen = index(each)
                    break
                left -= _1
        entry = begun + chosen
        value = 0.0 if following[entry] & _1 else greatest_of(memory.q, following[entry], n_actions)
        learn_one_step(memory.q, memory.updates, rules, alpha, power, entry, gains[entry], value)
