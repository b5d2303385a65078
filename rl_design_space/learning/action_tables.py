"""Actions that follow a table: which step each makes at an observation, where it stops, and after how many steps.

Primitive actions and multi-step actions of fixed length need no table; for them `moving` and `updating` are faster. A
table gives the same results.

The *control* of an action at an observation is described in `controls`. An action ends on arriving where it stops,
where its mark differs from the one where it began, at its limit, at the final goal, at the step cap, and at a due
sub-goal under that reading.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.chance import earned, land
from rl_design_space.learning.compiled import compiled, inlined
from rl_design_space.learning.controls import MARK, STEP, STOP
from rl_design_space.learning.lanes import (
    ACTION,
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
from rl_design_space.learning.moving import maximum, see
from rl_design_space.learning.updating import updated

_STEP, _STOP, _MARK = index(STEP), index(STOP), index(MARK)
_WAITS = index(4)
#: Of a cell in the table of steps.
_STEP_BITS = index(3)
_0, _1 = index(0), index(1)


@compiled
def step_table(next_cell, table):
    """Return the cell that each step leads to, by cell and step; with a table, the fifth step of eight is to wait."""
    if table is None:
        return np.ascontiguousarray(next_cell.T).ravel()
    steps = np.zeros((next_cell.shape[1], 8), dtype=next_cell.dtype)
    for cell in range(len(steps)):
        for step in range(4):
            steps[cell, step] = next_cell[step, cell]
        steps[cell, 4] = cell
    return steps.ravel()


@compiled
def enter_controls(table, marks, entries, first, entered):
    """Fill the controls of a lane, by row and action.

    Args:
        table: the controls of an `ActionTable`, of one period.
        marks: (n_goals · cells) uint32, numbers of the marks.
        entries: offset of the row of each success counter and cell, without its kind.
        first: offset of the lane's first row.
        entered: the controls of the lane, output.
    """
    for at in range(len(entries)):
        row = entries[at] - first
        for action in range(table.shape[1]):
            entered[row + action] = table[at, action] | (marks[at] << 4)


@inlined
def move_by_table(
    numbers, reals, values, q, running, next_of, entries, limits, limit_of, rules, reward_of, cells, passed, rewards,
    made, controls, went, chance, pay,
):  # fmt: skip
    """Execute the chosen actions step by step; goals passed on the way count."""
    for place in range(running):
        lane = index(place)
        row, action, stage = numbers[ROW + lane], numbers[ACTION + lane], numbers[STAGE + lane]
        cell = numbers[CELL + lane]
        length = limit_of[action]
        # The return of a multi-step action as printed in the paper: one term too many, all with the first reward.
        printed = (length > 1) & rules.printed_msa_reward
        limit = min(length, rules.max_steps - np.int64(numbers[MOVES + lane]))
        began = index(controls[row + action])
        control = began
        passed[lane] = row
        executed = 0
        entry = _0
        gain = 0.0
        discount = 1.0
        going = True
        while going:
            step = control & _STEP
            made[index(executed * LANES) + lane] = step
            state, outcome = stage + cell, _0
            if chance is None:
                cell = index(next_of[(cell << _STEP_BITS) + step])
            else:
                cell, outcome = land(numbers, lane, (cell << _STEP_BITS) + step, chance)
                went[index(executed * LANES) + lane] = cell
            entry = index(entries[stage + cell])
            kind = entry & KIND
            reward = reward_of[kind] if pay is None else earned(state, step, outcome, pay)
            rewards[index(executed * LANES) + lane] = reward
            gain += discount * (rewards[lane] if printed else reward)
            discount *= rules.gamma
            stage += cells * (kind >> _1)
            executed += 1
            passed[index(executed * LANES) + lane] = entry ^ kind
            control = index(controls[(entry ^ kind) + action])
            ends = (kind == FINAL_GOAL) | (executed == limit) | _stops(began, control)
            going = not (ends | ((kind >= SUB_GOAL) & rules.stop_at_sub_goal))
        numbers[CELL + lane] = cell
        numbers[STAGE + lane] = stage
        numbers[ENTRY + lane] = entry
        numbers[EXECUTED + lane] = index(executed)
        reals[RETURN + lane] = gain + discount * rewards[lane] if printed else gain
        reals[DISCOUNT + lane] = discount
        reals[OLD + lane] = q[row + action]
        see(values, q, entry & ~KIND, lane, limits)


@inlined
def _stops(began, control):
    """Return whether an action stops on arriving at this control, having begun at that one."""
    return ((control & _STOP) | ((began ^ control) & _MARK)) != _0


@inlined
def propagate_by_table(numbers, values, q, running, limits, limit_of, rules, passed, rewards, made, controls):
    """Update other actions from the rows passed, and show each lane its new row."""
    for place in range(running):
        lane = index(place)
        if rules.consistent:
            _propagate_to_consistent(numbers, q, lane, limits, limit_of, rules, passed, rewards, made, controls)
        else:
            _propagate_to_shorter(numbers, q, lane, limits, limit_of, rules, passed, rewards, made)
        see(values, q, numbers[ROW + lane], lane, limits)


@inlined
def _propagate_to_shorter(numbers, q, lane, limits, limit_of, rules, passed, rewards, made):
    """Update the shorter actions that the executed action contains, as `updating.propagate` does."""
    executed = np.int64(numbers[EXECUTED + lane])
    terminal = numbers[ENTRY + lane] & KIND == FINAL_GOAL
    length = limit_of[numbers[ACTION + lane]]
    for choice in range(rules.propagated_lengths):
        shorter = limit_of[4 * choice]
        times = executed - shorter + 1 if shorter < length else 0
        for first in range(times):
            step = made[index(first * LANES) + lane]
            if step == _WAITS:
                continue
            last = first + shorter
            gain = 0.0
            discount = 1.0
            for at in range(first, last):
                gain += discount * rewards[index(at * LANES) + lane]
                discount *= rules.gamma
            best_next = maximum(q, passed[index(last * LANES) + lane], len(limits))
            best_next = 0.0 if terminal & (last == executed) else best_next
            at = passed[index(first * LANES) + lane] + step + index(4 * choice)
            q[at] = updated(q[at], gain, discount, best_next, rules)


@inlined
def _propagate_to_consistent(numbers, q, lane, limits, limit_of, rules, passed, rewards, made, controls):
    """Update every action that would have made the same steps from a row passed on, and would have ended by itself.

    In order of their numbers, each in order of time. The executed action itself learns where it began by its own
    update, and here where it would have begun later.
    """
    executed, entry = np.int64(numbers[EXECUTED + lane]), numbers[ENTRY + lane]
    kind = entry & KIND
    terminal = kind == FINAL_GOAL
    all_stop = terminal | ((kind >= SUB_GOAL) & rules.stop_at_sub_goal)
    for action in range(len(limits)):
        own = index(action)
        for first in range(int(own == numbers[ACTION + lane]), executed):
            row = passed[index(first * LANES) + lane]
            began = index(controls[row + own])
            control = began
            limit = min(limit_of[action], executed - first)
            count = 0
            gain = 0.0
            discount = 1.0
            same, ended = True, False
            while same and not ended and count < limit:
                at = index((first + count) * LANES) + lane
                same = control & _STEP == made[at]
                gain += discount * rewards[at]
                discount *= rules.gamma
                count += 1
                control = index(controls[passed[at + index(LANES)] + own])
                ended = _stops(began, control)
            last = first + count
            ended |= (count == limit_of[action]) | (all_stop & (last == executed))
            if same and ended:
                best_next = maximum(q, passed[index(last * LANES) + lane], len(limits))
                best_next = 0.0 if terminal & (last == executed) else best_next
                q[row + own] = updated(q[row + own], gain, discount, best_next, rules)
