"""Executing actions: the agents of all lanes move, and the row of the Q-matrix of their new observation is looked up.

These loops access memory at random. They do little else, so that the processor runs far ahead and loads the rows of
the next lanes while it waits for this one.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.chance import earned, land
from rl_design_space.learning.compiled import compiled, inlined
from rl_design_space.learning.lanes import (
    ACTION,
    CELL,
    DISCOUNT,
    ENTRY,
    EXECUTED,
    FINAL_GOAL,
    KIND,
    LANES,
    MAXIMA,
    MOVES,
    OLD,
    RETURN,
    ROW,
    STAGE,
    SUB_GOAL,
    index,
)
from rl_design_space.learning.rows import best_of, bits_of_best, lowest_bit
from rl_design_space.learning.updating import propagate, updated

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
def look(numbers, q, running, limits):
    """Note which actions have the maximum of each lane's current row.

    With multi-step actions, whose rows have 8 values or more, this takes fewer instructions than `see`, which copies.
    """
    for place in range(running):
        lane = index(place)
        row = numbers[ROW + lane]
        numbers[MAXIMA + lane] = bits_of_best(q, row, best_of(q, row, limits), limits)


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


@compiled
def powers(discount, highest):
    """Return discount^0 to discount^highest, by repeated multiplication."""
    found = np.ones(highest + 1)
    for exponent in range(highest):
        found[exponent + 1] = found[exponent] * discount
    return found


@inlined
def _lanes_with(numbers, wide, running, choice):
    """Return the lanes whose actions are those of a group of four, of equal length, as bits of a number.

    Loops of equal length in a row are predicted by the processor.
    """
    found = _0
    for lane in range(wide):
        found |= index(numbers[ACTION + index(lane)] >> _2 == index(choice)) << index(lane)
    return found & ((_1 << index(running)) - _1)


@inlined
def move_on(
    numbers, reals, values, q, wide, running, next_of, entries, limits, limit_of, rules, reward_of, discounts, cells,
    passed, rewards, went, chance, pay,
):  # fmt: skip
    """Execute the chosen actions, which repeat their step, length by length; goals passed on the way count.

    A lane learns from an action of several steps at once, while the rows that it has passed are at hand: separate loops
    would be ended, and predicted wrongly, once more.
    """
    waiting = _lanes_with(numbers, wide, running, 0)
    while waiting != _0:
        lane = lowest_bit(waiting)
        waiting &= waiting - _1
        state = numbers[STAGE + lane] + numbers[CELL + lane]
        entry, outcome = _step(numbers, lane, next_of, entries, chance)
        if chance is not None:
            went[lane] = numbers[CELL + lane]
        kind = entry & KIND
        numbers[STAGE + lane] += cells & (_0 - (kind >> _1))
        numbers[EXECUTED + lane] = _1
        if pay is None:
            reals[RETURN + lane] = reward_of[kind]
        else:
            reals[RETURN + lane] = earned(state, numbers[ACTION + lane], outcome, pay)
        reals[DISCOUNT + lane] = rules.gamma
        reals[OLD + lane] = q[numbers[ROW + lane] + numbers[ACTION + lane]]
        values[lane] = best_of(q, entry & ~KIND, limits)
    # Of sub-goals and final goals: the least kind of cell that stops an action.
    stops = SUB_GOAL if rules.stop_at_sub_goal else FINAL_GOAL
    for choice in range(1, len(limits) // 4):
        length = limit_of[4 * choice]
        waiting = _lanes_with(numbers, wide, running, choice)
        while waiting != _0:
            lane = lowest_bit(waiting)
            waiting &= waiting - _1
            row, action = numbers[ROW + lane], numbers[ACTION + lane]
            stage, cell = numbers[STAGE + lane], numbers[CELL + lane]
            limit = min(length, rules.max_steps - np.int64(numbers[MOVES + lane]))
            step = action & _3
            passed[lane] = row
            executed = 0
            entry = _0
            gain = 0.0
            discount = 1.0
            while executed < limit:
                state, outcome = stage + cell, _0
                if chance is None:
                    cell = index(next_of[(cell << _2) + step])
                else:
                    cell, outcome = land(numbers, lane, (cell << _2) + step, chance)
                    went[index(executed * LANES) + lane] = cell
                entry = index(entries[stage + cell])
                kind = entry & KIND
                reward = reward_of[kind] if pay is None else earned(state, step, outcome, pay)
                rewards[index(executed * LANES) + lane] = reward
                gain += discount * reward
                discount *= rules.gamma
                executed += 1
                passed[index(executed * LANES) + lane] = entry ^ kind
                # Predicted, so that the next look-up does not wait for this one.
                if kind >= SUB_GOAL:
                    stage += cells
                    if kind >= stops:
                        break
            if rules.printed_msa_reward:
                # One term too many, all with the first reward.
                gain = 0.0
                factor = 1.0
                for _ in range(executed + 1):
                    gain += factor * rewards[lane]
                    factor *= rules.gamma
            numbers[CELL + lane] = cell
            numbers[STAGE + lane] = stage
            numbers[ENTRY + lane] = entry
            numbers[EXECUTED + lane] = index(executed)
            reals[RETURN + lane] = gain
            reals[DISCOUNT + lane] = discount
            old, best_next = q[row + action], best_of(q, entry & ~KIND, limits)
            reals[OLD + lane] = old
            values[lane] = best_next
            if rules.propagated_lengths > 0:
                # The number of the step after which nothing is to come; none if the trial goes on.
                end = executed if entry & KIND == FINAL_GOAL else -1
                best_next = 0.0 if end == executed else best_next
                # `update` computes the same value, and `keep` writes it once more, as other lanes need that.
                q[row + action] = updated(old, gain, discount, best_next, rules)
                propagate(q, lane, step, length, executed, end, limits, limit_of, rules, discounts, passed, rewards)
