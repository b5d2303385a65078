"""Learning from executed actions: one-step Q-learning, and propagation to the parts of multi-step actions."""

from __future__ import annotations

from rl_design_space.learning.compiled import inlined
from rl_design_space.learning.lanes import (
    ACTION,
    DISCOUNT,
    ENDED,
    ENTRY,
    EXECUTED,
    FINAL_GOAL,
    KIND,
    LANES,
    MOVES,
    NEW,
    OLD,
    OUT_OF_ORDER,
    RETURN,
    ROW,
    SEEN,
    STAGE,
    SUB_GOAL,
    UPDATED,
    index,
)
from rl_design_space.learning.rows import best_of

_0, _1 = index(0), index(1)


@inlined
def updated(old, gain, discount, best_next, rules):
    """Return a Q-value after an update towards gain + discount · best_next."""
    if rules.printed_update:
        return old + rules.alpha * (gain + discount * (best_next - old))
    return old + rules.alpha * (gain + discount * best_next - old)


@inlined
def update(numbers, reals, values, running, cells, limits, rules, one_step, in_rows, pay):
    """Compute the new Q-values of the chosen actions, and the next states of the agents.

    The best value of the next state is taken before this update. The target includes it unless the next state is
    terminal; the state at the step cap is not terminal. With `in_rows`, the best value is the first of `values`.

    Returns:
        Whether any trial has ended, and whether any update has changed a value of an agent's current row.
    """
    some_ended = some_seen = _0
    for lane in range(running):
        entry, row, action = numbers[ENTRY + lane], numbers[ROW + lane], numbers[ACTION + lane]
        kind = entry & KIND
        terminal = kind == FINAL_GOAL
        best_next = values[lane]
        for other in range(1, 1 if in_rows else len(limits)):
            value = values[index(other * LANES) + lane]
            best_next = value if value > best_next else best_next
        if one_step:
            if pay is None:
                gain = rules.step_reward
                gain = rules.out_of_order_reward if kind == OUT_OF_ORDER else gain
                gain = rules.sub_goal_reward if kind == SUB_GOAL else gain
                gain = rules.final_goal_reward if terminal else gain
            else:
                gain = reals[RETURN + lane]
            discount, made = rules.gamma, _1
            # Without a condition: conditional stores are not vectorised.
            numbers[STAGE + lane] += cells & (_0 - (kind >> _1))
        else:
            made = numbers[EXECUTED + lane]
            gain, discount = reals[RETURN + lane], reals[DISCOUNT + lane]
        best_next = 0.0 if terminal else best_next
        reals[NEW + lane] = updated(reals[OLD + lane], gain, discount, best_next, rules)

        next_row = entry ^ kind
        same = next_row == row
        numbers[UPDATED + lane] = row + action
        numbers[SEEN + lane] = action if same else index(len(limits))
        numbers[ROW + lane] = next_row
        moves = numbers[MOVES + lane] + made
        ended = index(terminal | (moves == index(rules.max_steps)))
        numbers[MOVES + lane] = moves
        numbers[ENDED + lane] = ended
        some_ended |= ended
        some_seen |= index(same)
    return some_ended != _0, some_seen != _0


@inlined
def keep(numbers, reals, values, q, running, some_seen):
    """Write the new Q-values to the Q-matrices, and to the current rows that hold them."""
    for lane in range(running):
        q[numbers[UPDATED + index(lane)]] = reals[NEW + index(lane)]
    if some_seen:
        for lane in range(running):
            values[numbers[SEEN + index(lane)] * index(LANES) + index(lane)] = reals[NEW + index(lane)]


@inlined
def propagate(q, lane, step, length, executed, end, limits, limit_of, rules, discounts, passed, rewards):
    """Update the shorter actions that an executed action contains, from the cells passed, in order of time."""
    row = passed[lane]
    for first in range(executed):
        last_row = passed[index((first + 1) * LANES) + lane]
        gain = rewards[index(first * LANES) + lane]
        _update_part(q, row + step, last_row, limits, rules, first + 1 == end, gain, rules.gamma)
        row = last_row
    for choice in range(1, rules.propagated_lengths):
        shorter = limit_of[4 * choice]
        times = executed - shorter + 1 if shorter < length else 0
        for first in range(times):
            last = first + shorter
            gain = 0.0
            for at in range(first, last):
                gain += discounts[at - first] * rewards[index(at * LANES) + lane]
            row = passed[index(first * LANES) + lane]
            last_row = passed[index(last * LANES) + lane]
            at = row + step + index(4 * choice)
            _update_part(q, at, last_row, limits, rules, last == end, gain, discounts[shorter])


@inlined
def _update_part(q, at, last_row, limits, rules, terminal, gain, discount):
    """Update an action that an executed one contains, towards the maximum of the row where it ends."""
    best_next = best_of(q, last_row, limits)
    best_next = 0.0 if terminal else best_next
    q[at] = updated(q[at], gain, discount, best_next, rules)
