"""The compiled kernel: tabular Q-learning on tables, independent of grids, directions and schedules.

Several periods are learned side by side (`lanes`), each with a random stream of its own (`behaviour`), so the result of
a period does not depend on the others. In every iteration of the loop all agents choose an action (`behaviour`), then
all execute it (`moving`), then all learn (`updating`). From actions of several steps they learn as they execute them.

Numba counts references to arrays. It omits the counting in a loop only if the last use of every array that a function
gets is outside of any condition; that is why some values are computed first and discarded afterwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rl_design_space.learning.action_tables import move_by_table, propagate_by_table, step_table
from rl_design_space.learning.behaviour import choose, choose_by_bits, draw
from rl_design_space.learning.chance import pay_of
from rl_design_space.learning.compiled import compiled_and_kept
from rl_design_space.learning.lanes import (
    ENDED,
    ENTRY,
    FEW,
    FINAL_GOAL,
    KIND,
    MOVES,
    PERIOD,
    TRIAL,
    WIDTH,
    index,
)
from rl_design_space.learning.moving import look, move_on, move_once, powers
from rl_design_space.learning.periods import begin_period, begin_trial, end_period, swap
from rl_design_space.learning.rows import highest_bit
from rl_design_space.learning.sequential.periods import learn_in_sequence
from rl_design_space.learning.td_errors import add_errors, note_states, places_for_states
from rl_design_space.learning.updating import keep, update

_0, _1 = index(0), index(1)


class Rules(NamedTuple):
    """Parameters of the learner and rewards."""

    alpha: float
    gamma: float
    initial_q: float
    step_reward: float
    sub_goal_reward: float
    final_goal_reward: float
    out_of_order_reward: float
    explore_all: bool
    first_maximum: bool
    printed_update: bool
    printed_msa_reward: bool
    stop_at_sub_goal: bool
    #: Number of action lengths that learn from longer actions that contain them.
    propagated_lengths: int
    #: Whether all actions learn that would have made the same steps, see `action_tables`.
    consistent: bool
    max_steps: int


@compiled_and_kept
def learn(  # noqa: C901 (branches on `table`, `errors` and `method` are compiled away)
    next_cell, limits, threshold, rules, observation, first, layout, generator, lanes, drain, steps, success, rows,
    table, errors, chance, earnings, method,
):  # fmt: skip
    """Learn periods, as many side by side as there are lanes.

    The call returns when all its periods have begun and a lane is free. The next call continues the periods that still
    run, with the same lanes and arguments except `observation`, `first`, `drain`, `table` and
    `earnings`.

    Args:
        next_cell: (4, cells) int32, transition table.
        limits: the most steps of each action, ints. A tuple, so that the number of actions is known when the function
            is compiled.
        threshold: (trials,) uint64, ε · 2^32.
        rules: see `Rules`.
        observation: (taken, n_goals, cells) int64, observation codes of the periods to begin.
        first: number of the first of them.
        layout: (periods, 1 + n_goals) int32, start and goals of all periods, distinct in a period.
        generator: (periods, 4) uint64, initial states of the random generator.
        lanes: see `Lanes`; modified in place.
        drain: whether to continue until no period runs.
        steps: (periods, trials) int32, output: steps of every trial.
        success: (periods, trials) bool, output: whether the final goal was reached.
        rows: (periods, 2) int32, output: rows of the Q-matrix, and rows whose values learning has changed.
        table: what the actions do in the periods to begin, see `ActionTable`. None if action a makes limits[a] steps in
            direction a % 4: the first four are the primitive actions, and groups of four have equal limits.
        errors: output, see `Errors`; None to collect none, which costs nothing: the function is compiled without.
        chance: what steps may lead to, see `Chance`. None if that is certain; then nothing is drawn for it.
        earnings: (taken, n_goals · cells · width · k) float64, rewards of the periods to begin, by state, step and
            outcome, see `Pay`. None if rewards depend on the kind of cell alone.
        method: the learner, its behaviour and its step sizes, see `sequential.method.Method`: then all periods are
            learned by this call, one after the other. None for Q-learning with constant α and ε-greedy behaviour.
    """
    taken, n_goals, cells = observation.shape
    trials = steps.shape[1]
    one_step = table is None and len(limits) == 4
    # Whether decisions read rows of the Q-matrix as vectors instead of copies of their values by action.
    in_rows = table is None and not one_step
    next_of = step_table(next_cell, table)
    limit_of = np.array(limits)
    discounts = powers(rules.gamma, max(limits))
    reward_of = np.array((rules.step_reward, rules.out_of_order_reward, rules.sub_goal_reward, rules.final_goal_reward))
    if method is not None:
        learn_in_sequence(
            next_of, limits, rules, reward_of, observation, first, layout, generator, lanes, steps, success, rows,
            table, chance, earnings, method,
        )  # fmt: skip
        return
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
    begun_in = places_for_states(errors)

    running = int(lanes.running[0])
    begun = np.int64(0)  # a literal has a type of its own, for which functions would be compiled, too
    while True:
        while running < len(lanes.q) and begun < taken:
            period = first + begun
            codes = observation[begun].ravel()
            layout_of, state = layout[period], generator[period]
            begin_period(
                lanes, running, period, codes, layout_of, state, limits, rules.initial_q, rows, begun, table, earnings
            )
            start = index(layout[period, 0])
            begin_trial(numbers, values, q, entries, running, 0, start, threshold, observations, limits)
            running += 1
            begun += 1
        if running == 0 or not (drain or running == len(lanes.q)):
            break

        # Rounded up to full vectors: results of lanes that do not run are never used.
        wide = running if running <= FEW else (running + WIDTH - 1) // WIDTH * WIDTH
        if errors is not None:
            note_states(numbers, begun_in, running, observations)
        draw(numbers, wide)
        if in_rows:
            look(numbers, q, running, limits)
            choose_by_bits(numbers, wide, limits, rules)
        else:
            choose(numbers, values, wide, limits, rules)
        if table is None:
            if one_step:
                move_once(numbers, reals, values, q, running, next_of, entries, limits, chance, pay)
            else:
                move_on(
                    numbers, reals, values, q, wide, running, next_of, entries, limits, limit_of, rules, reward_of,
                    discounts, index(cells), passed, rewards, went, chance, pay,
                )  # fmt: skip
        else:
            move_by_table(
                numbers, reals, values, q, running, next_of, entries, limits, limit_of, rules, reward_of, index(cells),
                passed, rewards, made, controls, went, chance, pay,
            )  # fmt: skip
        some_ended, some_seen = update(
            numbers, reals, values, wide, index(cells), limits, rules, one_step, in_rows, pay
        )
        if errors is not None:
            add_errors(numbers, reals, begun_in, errors, running)
        keep(numbers, reals, values, q, running, some_seen and not in_rows)
        if table is not None:
            propagate_by_table(
                numbers, values, q, running, limits, limit_of, rules, passed, rewards, made, controls
            )  # fmt: skip
        if not some_ended:
            continue
        ended = _0
        for lane in range(running):
            ended |= numbers[ENDED + index(lane)] << index(lane)
        while ended != _0:
            lane = highest_bit(ended)
            ended ^= _1 << lane
            trial, period = np.int64(numbers[TRIAL + lane]), np.int64(numbers[PERIOD + lane])
            steps[period, trial] = numbers[MOVES + lane]
            success[period, trial] = numbers[ENTRY + lane] & KIND == FINAL_GOAL
            if trial + 1 < trials:
                start = index(layout[period, 0])
                begin_trial(numbers, values, q, entries, lane, trial + 1, start, threshold, observations, limits)
            else:
                end_period(lanes, lane, limits, rules.initial_q, rows, period)
                # The last lane replaces it; in this loop it was processed before.
                running -= 1
                swap(numbers, values, lane, running)
    lanes.running[0] = running
