"""Learning one period once more, with a record of every step: the kernel's own functions, one lane, and notes.

It is a function of its own, so that the kernel has nothing to ask in its loop. `replay` compares the steps of every
trial with those of the kernel.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.action_tables import move_by_table, propagate_by_table, step_table
from rl_design_space.learning.behaviour import choose, choose_by_bits, draw
from rl_design_space.learning.chance import pay_of
from rl_design_space.learning.compiled import compiled, compiled_and_kept
from rl_design_space.learning.lanes import (
    ACTION,
    CELL,
    ENTRY,
    EXECUTED,
    FINAL_GOAL,
    KIND,
    LANES,
    MOVES,
    THRESHOLD,
    WORD,
    index,
    row_width,
)
from rl_design_space.learning.moving import look, move_on, move_once, powers
from rl_design_space.learning.periods import begin_period, begin_trial
from rl_design_space.learning.updating import keep, update

_0, _32 = index(0), index(32)


@compiled
def _note(trail, at, begin, executed, action, explores, next_cell, layout, made, went):
    """Record the steps of an action that began in a cell; return where the next one is recorded.

    The cells passed follow from the transitions, except where chance decides: then they are noted in `went`. The last
    one alone is among the numbers of the lane.
    """
    cell = begin
    for number in range(executed):
        counter = trail.counters[at]
        # Actions that follow no table repeat one step; the fifth step of those that do is to wait.
        step = np.int64(made[number * LANES]) if len(made) else action & 3
        cell = np.int64(next_cell[step, cell]) if step < 4 else cell
        if len(went):
            cell = np.int64(went[number * LANES])
        trail.actions[at], trail.explored[at] = action, explores
        at += 1
        trail.cells[at] = cell
        trail.counters[at] = counter + int(cell == layout[1 + counter])
    return at


@compiled_and_kept
def record(
    next_cell, limits, threshold, rules, observation, layout, generator, lanes, q_after, trail, steps, success, table,
    chance, earnings,
):  # fmt: skip
    """Learn one period as `learn` does, and record it.

    Args:
        next_cell: see `learn`.
        limits: see `learn`.
        threshold: see `learn`.
        rules: see `Rules`.
        observation: (1, n_goals, cells) int64, observation codes.
        layout: (1, 1 + n_goals) int32, start and goals.
        generator: (1, 4) uint64, initial state of the random generator.
        lanes: one lane, not running.
        q_after: (trials, rows, n_actions) float64, output: Q-matrix after each trial; with 0 trials, not recorded.
        trail: output, the paths of all trials, one after the other, with a place for the end of each; with no places,
            not recorded.
        steps: (trials,) int32, output.
        success: (trials,) bool, output.
        table: see `learn`, of this period alone.
        chance: see `learn`.
        earnings: see `learn`, of this period alone.
    """
    _, n_goals, cells = observation.shape
    trials = len(steps)
    one_step = table is None and len(limits) == 4
    in_rows = table is None and not one_step
    next_of = step_table(next_cell, table)
    limit_of = np.array(limits)
    discounts = powers(rules.gamma, max(limits))
    reward_of = np.array((rules.step_reward, rules.out_of_order_reward, rules.sub_goal_reward, rules.final_goal_reward))
    numbers, reals, values, q, entries = (
        lanes.numbers,
        lanes.reals,
        lanes.values,
        lanes.q.ravel(),
        lanes.entries.ravel(),
    )
    passed, rewards = lanes.passed.ravel(), lanes.rewards.ravel()
    made, controls, went = lanes.made.ravel(), lanes.controls.ravel(), lanes.went.ravel()
    observations = index(n_goals * cells)
    pay = pay_of(lanes, earnings, chance, n_goals * cells)
    # Of the types that the kernel calls its functions with, so that they are not compiled again for literals.
    first, one = np.int64(0), np.int64(1)
    rows = np.empty((1, 2), dtype=np.int32)
    start = index(layout[0, 0])
    begin_period(
        lanes, first, first, observation[0].ravel(), layout[0], generator[0], limits, rules.initial_q, rows, first,
        table, earnings,
    )  # fmt: skip
    at = first
    for trial in range(trials):
        begin_trial(numbers, values, q, entries, _0, trial, start, threshold, observations, limits)
        if len(trail.cells):
            trail.cells[at], trail.counters[at] = layout[0, 0], 0
        ended = False
        while not ended:
            begin = np.int64(numbers[CELL])
            draw(numbers, one)
            if in_rows:
                look(numbers, q, one, limits)
                choose_by_bits(numbers, one, limits, rules)
            else:
                choose(numbers, values, one, limits, rules)
            action = np.int64(numbers[ACTION])
            explores = numbers[WORD] >> _32 < numbers[THRESHOLD]
            if table is None:
                if one_step:
                    move_once(numbers, reals, values, q, one, next_of, entries, limits, chance, pay)
                    if len(went):
                        went[0] = numbers[CELL]
                else:
                    move_on(
                        numbers, reals, values, q, one, one, next_of, entries, limits, limit_of, rules, reward_of,
                        discounts, index(cells), passed, rewards, went, chance, pay,
                    )  # fmt: skip
            else:
                move_by_table(
                    numbers, reals, values, q, one, next_of, entries, limits, limit_of, rules, reward_of, index(cells),
                    passed, rewards, made, controls, went, chance, pay,
                )  # fmt: skip
            some_ended, some_seen = update(
                numbers, reals, values, one, index(cells), limits, rules, one_step, in_rows, pay
            )
            keep(numbers, reals, values, q, one, some_seen and not in_rows)
            if table is not None:
                propagate_by_table(
                    numbers, values, q, one, limits, limit_of, rules, passed, rewards, made, controls
                )  # fmt: skip
            if len(trail.cells):
                executed = 1 if one_step else np.int64(numbers[EXECUTED])
                at = _note(trail, at, begin, executed, action, explores, next_cell, layout[0], made, went)
            ended = some_ended
        steps[trial] = numbers[MOVES]
        success[trial] = numbers[ENTRY] & KIND == FINAL_GOAL
        at += 1
        if len(q_after):
            for row in range(q_after.shape[1]):
                for column in range(len(limits)):
                    q_after[trial, row, column] = q[row * row_width(len(limits)) + column]
