"""Executing actions: the agents of all lanes move, and the row of the Q-matrix of their new observation is looked up.

These loops access memory at random. They do little else, so that the processor runs far ahead and loads the rows of
the next lanes while it waits for this one.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.chance import earned, land
from rl_design_space.learning.compiled import inlined
from rl_design_space.learning.lanes import (
    ACTION,
    BEST,
    CELL,
    DISCOUNT,
    ENTRY,
    EXECUTED,
    FINAL_GOAL,
    KIND,
    LANES,
    MOVES,
    OLD,
    RETURN,
    ROW,
    STAGE,
    SUB_GOAL,
    index,
)

_0, _1, _2, _3, _4 = (index(number) for number in range(5))


@inlined
def _step(numbers, lane, next_of, entries, chance):
    """Make one step; return the entry that it leads to, and the number of its outcome."""
    at, outcome = (numbers[CELL + lane] << _2) + (numbers[ACTION + lane] & _3), _0
    if chance is None:
        cell = index(next_of[at])
    else:
        cell, outcome = land(numbers, lane, at, chance)
    entry = index(entries[numbers[STAGE + lane] + cell])
    numbers[CELL + lane] = cell
    numbers[ENTRY + lane] = entry
    return entry, outcome


@inlined
def see(values, q, row, lane, limits):
    """Copy a row of the Q-matrix to the values that the lane's next decision reads."""
    for action in range(len(limits)):
        values[index(action * LANES) + lane] = q[row + index(action)]


@inlined
def maximum(q, row, n_actions):
    """Return the maximum of a row of the Q-matrix, by a tree of comparisons: updates wait for them."""
    best = q[row]
    if n_actions >= 4:
        best = max(max(q[row], q[row + _1]), max(q[row + _2], q[row + _3]))
    # In groups of four, and the rest one by one.
    rest = row + index(n_actions // 4 * 4)
    for at in range(row + _4, rest, _4):
        best = max(best, max(max(q[at], q[at + _1]), max(q[at + _2], q[at + _3])))
    for at in range(rest, row + index(n_actions)):
        best = max(best, q[at])
    return best


@inlined
def move_once(numbers, reals, values, q, running, next_of, entries, limits, chance, pay):
    """Execute the chosen actions, all of one step, and look up the rows that they lead to."""
    for place in range(running):
        lane = index(place)
        state = numbers[STAGE + lane] + numbers[CELL + lane]
        entry, outcome = _step(numbers, lane, next_of, entries, chance)
        if pay is not None:
            reals[RETURN + lane] = earned(state, numbers[ACTION + lane], outcome, pay)
        reals[OLD + lane] = q[numbers[ROW + lane] + numbers[ACTION + lane]]
        see(values, q, entry & ~KIND, lane, limits)


@inlined
def sort_by_length(numbers, running, limits, order):
    """Sort the lanes by the lengths of their actions: loops of equal length in a row are predicted by the processor."""
    sorted_lanes = 0
    for choice in range(len(limits) // 4):
        for lane in range(running):
            # An element that does not belong here is overwritten by the next one.
            order[sorted_lanes] = lane
            sorted_lanes += int(numbers[ACTION + index(lane)] >> _2 == index(choice))


@inlined
def move_on(
    numbers, reals, q, running, next_of, entries, limits, limit_of, rules, reward_of, cells, passed, rewards, order,
    went, chance, pay,
):  # fmt: skip
    """Execute the chosen actions step by step, in the order of `sort_by_length`; goals passed on the way count."""
    for place in range(running):
        lane = index(order[place])
        row, action, stage = numbers[ROW + lane], numbers[ACTION + lane], numbers[STAGE + lane]
        cell = numbers[CELL + lane]
        length = limit_of[action]
        # The return of a multi-step action as printed in the paper: one term too many, all with the first reward.
        printed = (length > 1) & rules.printed_msa_reward
        limit = min(length, rules.max_steps - np.int64(numbers[MOVES + lane]))
        passed[lane] = row
        executed = 0
        entry = _0
        gain = 0.0
        discount = 1.0
        going = True
        while going:
            state, outcome = stage + cell, _0
            if chance is None:
                cell = index(next_of[(cell << _2) + (action & _3)])
            else:
                cell, outcome = land(numbers, lane, (cell << _2) + (action & _3), chance)
                went[index(executed * LANES) + lane] = cell
            entry = index(entries[stage + cell])
            kind = entry & KIND
            reward = reward_of[kind] if pay is None else earned(state, action & _3, outcome, pay)
            rewards[index(executed * LANES) + lane] = reward
            gain += discount * (rewards[lane] if printed else reward)
            discount *= rules.gamma
            stage += cells * (kind >> _1)
            executed += 1
            passed[index(executed * LANES) + lane] = entry ^ kind
            ends = (kind == FINAL_GOAL) | (executed == limit)
            going = not (ends | ((kind >= SUB_GOAL) & rules.stop_at_sub_goal))
        numbers[CELL + lane] = cell
        numbers[STAGE + lane] = stage
        numbers[ENTRY + lane] = entry
        numbers[EXECUTED + lane] = index(executed)
        reals[RETURN + lane] = gain + discount * rewards[lane] if printed else gain
        reals[DISCOUNT + lane] = discount
        reals[OLD + lane] = q[row + action]
        reals[BEST + lane] = maximum(q, entry & ~KIND, len(limits))
