"""The one compiled function of the project: tabular Q-learning on tables.

It knows nothing of grids, directions or schedules. Its random numbers come from xoshiro256++ (Blackman and
Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS 47, 2021), one 64-bit word a decision: the
upper half decides whether to explore, the lower half which action it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

#: ε is compared in steps of 2^-32.
COIN_SIDES = 2**32

_compiled = njit(nogil=True, cache=True, error_model="numpy")

# Indices are unsigned, so that no index has to be tested for being negative, and a row of the Q-matrix goes by
# the place of its first value: both shorten the way from one observation to the next.
_index = np.uint64
_1, _2, _3, _4, _32 = _index(1), _index(2), _index(3), _index(4), _index(32)
_LOW = _index(0xFFFFFFFF)


class Rules(NamedTuple):
    """What the learner does, as numbers."""

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
    #: How many of the action lengths learn from a longer action that contains them.
    propagated_lengths: int
    max_steps: int


@_compiled
def _rotated(word, bits):
    return (word << _index(bits)) | (word >> _index(64 - bits))


@_compiled
def _next_word(s0, s1, s2, s3):
    """One word of xoshiro256++ and the state after it."""
    word = _rotated(s0 + s3, 23) + s0
    shifted = s1 << _index(17)
    s2 ^= s0
    s3 ^= s1
    s1 ^= s2
    s0 ^= s3
    s2 ^= shifted
    s3 = _rotated(s3, 45)
    return word, s0, s1, s2, s3


@_compiled
def _maximum(q, row, n_actions):
    """The largest value of a row of the Q-matrix, as a tree of comparisons: they are what a decision waits for."""
    best = max(max(q[row], q[row + _1]), max(q[row + _2], q[row + _3]))
    for at in range(row + _4, row + n_actions, _4):
        best = max(best, max(max(q[at], q[at + _1]), max(q[at + _2], q[at + _3])))
    return best


@_compiled
def _choice(q, row, n_actions, best, word, threshold, rules):
    """ε-greedy: the action that one random word chooses in a row whose maximum is known."""
    lower = word & _LOW
    explores = (word >> _32) < threshold
    if explores and rules.explore_all:
        return (lower * n_actions) >> _32
    count = _1
    if not rules.first_maximum:
        count = _index(0)
        for action in range(n_actions):
            count += _index(q[row + action] == best)
    # The product's upper part draws one of `count` maxima; its lower part is still uniform for the next draw.
    product = lower * count
    skip = product >> _32
    # Counted without branches, because which action is the best is hard to predict.
    greedy = seen = _index(0)
    for action in range(n_actions):
        seen += _index(q[row + action] == best)
        greedy += _index(seen <= skip)
    if not explores:
        return greedy
    other = ((product & _LOW) * (n_actions - _1)) >> _32
    return other + _index(other >= greedy)


@_compiled
def _update(q, at, reward, discount, best_next, rules):
    """Move one value towards reward + discount · best_next."""
    old = q[at]
    if rules.printed_update:
        q[at] = old + rules.alpha * (reward + discount * (best_next - old))
    else:
        q[at] = old + rules.alpha * (reward + discount * best_next - old)


@_compiled
def _reward(goal, reached, n_goals, rules):
    """Reward of a move onto a cell that holds this goal, -1 for none, when `reached` goals have been met."""
    if goal < 0:
        return rules.step_reward
    if goal != reached:
        return rules.out_of_order_reward
    return rules.final_goal_reward if goal == n_goals - 1 else rules.sub_goal_reward


@_compiled
def _discounted(rewards, first, last, gamma):
    """Σ γ^j rewards[first + j] up to before `last`, and the discount that follows."""
    result = 0.0
    discount = 1.0
    for step in range(first, last):
        result += discount * rewards[step]
        discount *= gamma
    return result, discount


@_compiled
def _propagate(q, rows, rewards, executed, terminal, move, length, lengths, n_actions, rules):
    """Let the shorter actions contained in an executed one learn from the cells that it passed."""
    for index in range(rules.propagated_lengths):
        shorter = lengths[index]
        if shorter < length:
            for first in range(executed - shorter + 1):
                last = first + shorter
                result, discount = _discounted(rewards, first, last, rules.gamma)
                best_next = 0.0
                if last < executed or not terminal:
                    best_next = _maximum(q, rows[last], n_actions)
                _update(q, rows[first] + move + _index(4 * index), result, discount, best_next, rules)


@_compiled
def _printed_return(reward, executed, gamma):
    """The return of a multi-step action by the letter of the paper: one term too many, all with one reward."""
    result = 0.0
    discount = 1.0
    for _ in range(executed + 1):
        result += discount * reward
        discount *= gamma
    return result


@_compiled
def _rows_after(rows_of, next_of, n_actions, rows_after):
    """Where each move leads while the success counter stays, so that no decision waits for the cell first."""
    cells = len(next_of) // 4
    for stage in range(0, len(rows_of), cells):
        for entry in range(4 * cells):
            rows_after[4 * stage + entry] = rows_of[stage + next_of[entry]] * n_actions


@_compiled
def _trial(
    q, state, start, n_goals, cells, next_of, goal_at, rows_of, rows_after, threshold, lengths, rules, rows, rewards
):
    """One trial from the start to the final goal or the step cap.

    Returns:
        Primitive moves made, whether the final goal was reached, and the random generator's state.
    """
    n_actions = _index(4 * len(lengths))
    s0, s1, s2, s3 = state
    cell = _index(start)
    reached = 0
    stage = _index(0)  # where the observations after `reached` goals begin
    moves = 0
    row = _index(rows_of[cell]) * n_actions
    best = _maximum(q, row, n_actions)

    while reached < n_goals and moves < rules.max_steps:
        word, s0, s1, s2, s3 = _next_word(s0, s1, s2, s3)
        action = _choice(q, row, n_actions, best, word, threshold, rules)
        move = action & _3
        length = lengths[action >> _2] if len(lengths) > 1 else 1

        # Execute the action, move by move: a goal counts wherever it is met.
        executed = 0
        result = 0.0
        discount = 1.0
        next_row = row
        while executed < length:
            if len(lengths) > 1:
                rows[executed] = next_row
            next_row = _index(rows_after[((stage + cell) << _2) + move])
            cell = _index(next_of[(cell << _2) + move])
            goal = goal_at[cell]
            reward = _reward(goal, reached, n_goals, rules)
            if len(lengths) > 1:
                rewards[executed] = reward
            result += discount * reward
            discount *= rules.gamma
            executed += 1
            met = goal == reached
            if met:
                reached += 1
                stage += _index(cells)
                if reached == n_goals:
                    break
                next_row = _index(rows_of[stage + cell]) * n_actions
            if moves + executed == rules.max_steps or (met and rules.stop_at_sub_goal):
                break
        moves += executed
        if length > 1 and rules.printed_msa_reward:
            result = _printed_return(rewards[0], executed, rules.gamma)

        # The last state bootstraps unless it is terminal; the one at the step cap is not.
        terminal = reached == n_goals
        best = 0.0 if terminal else _maximum(q, next_row, n_actions)
        _update(q, row + action, result, discount, best, rules)
        if length > 1:
            rows[executed] = next_row
            _propagate(q, rows, rewards, executed, terminal, move, length, lengths, n_actions, rules)
        # Read again, because the updates may have changed this very row.
        best = _maximum(q, next_row, n_actions)
        row = next_row

    return moves, reached == n_goals, (s0, s1, s2, s3)


@_compiled
def learn(next_cell, observation, layout, threshold, lengths, rules, generator, q, steps, success):
    """Learn a number of periods, each from a fresh Q-matrix.

    Args:
        next_cell: (4, cells) int32, transition table.
        observation: (periods, n_goals, cells) int32, rows of the Q-matrix.
        layout: (periods, 1 + n_goals) int32, start and goals.
        threshold: (trials,) uint64, ε · 2^32.
        lengths: 1 + m ints, the moves that an action of each length makes; the first is 1. A tuple, so that their
            number, and with it the number of actions, is known when the function is compiled.
        rules: see `Rules`.
        generator: (periods, 4) uint64, initial states of the random generator.
        q: (rows, 4 · (1 + m)) float64, contiguous, overwritten; holds the last period's Q-matrix at the end. Action a
            repeats move a % 4 lengths[a // 4] times.
        steps: (periods, trials) int32, written: primitive moves of every trial.
        success: (periods, trials) bool, written: whether the final goal was reached.
    """
    periods, n_goals, cells = observation.shape
    next_of = np.ascontiguousarray(next_cell.T).ravel()
    table = q.ravel()
    goal_at = np.full(cells, -1, dtype=np.int32)
    rows_after = np.empty(4 * n_goals * cells, dtype=np.uint32)
    rows = np.empty(max(lengths) + 1, dtype=np.uint64)
    rewards = np.empty(max(lengths), dtype=np.float64)

    for period in range(periods):
        table[:] = rules.initial_q
        rows_of = observation[period].ravel()
        state = (generator[period, 0], generator[period, 1], generator[period, 2], generator[period, 3])
        _rows_after(rows_of, next_of, 4 * len(lengths), rows_after)
        start = layout[period, 0]
        for goal in range(n_goals):
            goal_at[layout[period, 1 + goal]] = goal

        for trial in range(steps.shape[1]):
            steps[period, trial], success[period, trial], state = _trial(
                table, state, start, n_goals, cells, next_of, goal_at, rows_of, rows_after, threshold[trial],
                lengths, rules, rows, rewards,
            )  # fmt: skip

        for goal in range(n_goals):
            goal_at[layout[period, 1 + goal]] = -1
