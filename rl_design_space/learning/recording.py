"""Learning one period once more, with a record of every step: the kernel's own functions, one lane, and notes.

It is a function of its own, so that the kernel has nothing to ask in its loop. `replay` compares the steps of every
trial with those of the kernel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space.learning.behaviour import choose, draw
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
)
from rl_design_space.learning.moving import move_on, move_once, sort_by_length
from rl_design_space.learning.periods import begin_period, begin_trial
from rl_design_space.learning.updating import keep, propagate, update

_32 = index(32)


class Path(NamedTuple):
    """The way of the agent in one trial of k steps.

    Attributes:
        cells: (k + 1,) int32, from the start to the final goal, or to where the step cap ended the trial.
        counters: (k + 1,) int32, success counter in each of these states; the number of goals at the final goal.
        actions: (k,) int32, the action that each step belongs to; its direction is that number modulo 4.
        explored: (k,) bool, whether the action was an exploratory one.
    """

    cells: NDArray[np.int32]
    counters: NDArray[np.int32]
    actions: NDArray[np.int32]
    explored: NDArray[np.bool_]


@compiled
def _note(trail, at, begin, executed, action, explores, next_cell, layout):
    """Record the steps of an action that began in a cell; return where the next one is recorded.

    The cells passed follow from the transitions: only the last one is among the numbers of the lane.
    """
    cell = begin
    for _ in range(executed):
        counter = trail.counters[at]
        cell = next_cell[action & 3, cell]
        trail.actions[at], trail.explored[at] = action, explores
        at += 1
        trail.cells[at] = cell
        trail.counters[at] = counter + int(cell == layout[1 + counter])
    return at


@compiled_and_kept
def record(next_cell, lengths, threshold, rules, observation, layout, generator, lanes, q_after, trail, steps, success):
    """Learn one period as `learn` does, and record it.

    Args:
        next_cell: see `learn`.
        lengths: see `learn`.
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
    """
    _, n_goals, cells = observation.shape
    trials = len(steps)
    n_actions = 4 * len(lengths)
    next_of = np.ascontiguousarray(next_cell.T).ravel()
    moves_of = np.array(lengths)
    reward_of = np.array((rules.step_reward, rules.out_of_order_reward, rules.sub_goal_reward, rules.final_goal_reward))
    numbers, reals, values, q, entries = (
        lanes.numbers,
        lanes.reals,
        lanes.values,
        lanes.q.ravel(),
        lanes.entries.ravel(),
    )
    order = np.empty(LANES + 1, dtype=np.int64)
    passed, rewards = lanes.passed.ravel(), lanes.rewards.ravel()
    observations = index(n_goals * cells)
    rows = np.empty((1, 2), dtype=np.int32)
    start = index(layout[0, 0])
    begin_period(lanes, 0, 0, observation[0].ravel(), layout[0], generator[0], n_actions, rules.initial_q, rows)
    at = 0
    for trial in range(trials):
        begin_trial(numbers, values, q, entries, 0, trial, start, threshold, observations, lengths)
        if len(trail.cells):
            trail.cells[at], trail.counters[at] = layout[0, 0], 0
        ended = False
        while not ended:
            begin = np.int64(numbers[CELL])
            draw(numbers, 1)
            choose(numbers, values, 1, lengths, rules)
            action = np.int64(numbers[ACTION])
            explores = numbers[WORD] >> _32 < numbers[THRESHOLD]
            if len(lengths) == 1:
                move_once(numbers, reals, values, q, 1, next_of, entries, lengths)
            else:
                sort_by_length(numbers, 1, lengths, order)
                move_on(
                    numbers, reals, q, 1, next_of, entries, lengths, moves_of, rules, reward_of, index(cells),
                    passed, rewards, order,
                )  # fmt: skip
            some_ended, some_seen = update(numbers, reals, values, 1, index(cells), lengths, rules)
            keep(numbers, reals, values, q, 1, some_seen & (len(lengths) == 1))
            if len(lengths) > 1:
                propagate(numbers, values, q, 1, lengths, moves_of, rules, passed, rewards, order)
            if len(trail.cells):
                executed = np.int64(numbers[EXECUTED]) if len(lengths) > 1 else 1
                at = _note(trail, at, begin, executed, action, explores, next_cell, layout[0])
            ended = some_ended
        steps[trial] = numbers[MOVES]
        success[trial] = numbers[ENTRY] & KIND == FINAL_GOAL
        at += 1
        if len(q_after):
            size = q_after.shape[1] * n_actions
            q_after[trial] = q[:size].copy().reshape(q_after.shape[1], n_actions)
