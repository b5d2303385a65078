"""The one compiled function of the project: tabular Q-learning on tables.

It knows nothing of grids, directions or schedules. Several periods are learned side by side (`lanes`), each on
random numbers of its own (`behaviour`), so a period comes out the same whatever runs beside it.

Numba counts references to arrays. It leaves the counting out of a loop only if every array that a function gets is
used last outside of any condition; that is why some values are computed first and dropped after.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rl_design_space.learning.behaviour import choose, draw
from rl_design_space.learning.compiled import compiled, compiled_and_kept, inlined
from rl_design_space.learning.lanes import (
    ACTION,
    CELL,
    HOME,
    LANES,
    MOVES,
    PERIOD,
    ROW,
    S0,
    STAGE,
    THRESHOLD,
    TRIAL,
    index,
)

_0, _1, _2, _3 = index(0), index(1), index(2), index(3)

#: Kinds of cells that a move can lead to, the two low bits of an entry: without a goal, with one that is not due,
#: with the due one, with the due one that is the last.
_PLAIN, _OUT_OF_ORDER, _SUB_GOAL, _FINAL_GOAL = range(4)


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


@inlined
def _maximum(q, row, n_actions):
    """The largest value of a row of the Q-matrix, as a tree of comparisons: they are what an update waits for."""
    best = max(max(q[row], q[row + _1]), max(q[row + _2], q[row + _3]))
    for at in range(row + index(4), row + n_actions, index(4)):
        best = max(best, max(max(q[at], q[at + _1]), max(q[at + _2], q[at + _3])))
    return best


@inlined
def _update(q, at, reward, discount, best_next, rules):
    """Move one value towards reward + discount · best_next."""
    old = q[at]
    if rules.printed_update:
        q[at] = old + rules.alpha * (reward + discount * (best_next - old))
    else:
        q[at] = old + rules.alpha * (reward + discount * best_next - old)


@inlined
def _discounted(rewards, first, last, gamma):
    """Σ γ^j rewards[first + j] up to before `last`, and the discount that follows."""
    result = 0.0
    discount = 1.0
    for step in range(first, last):
        result += discount * rewards[step]
        discount *= gamma
    return result, discount


@inlined
def _propagate(q, rows, rewards, executed, terminal, move, length, moves_of, n_actions, rules):
    """Let the shorter actions contained in an executed one learn from the cells that it passed."""
    for choice in range(rules.propagated_lengths):
        shorter = moves_of[choice]
        times = executed - shorter + 1 if shorter < length else 0
        for first in range(times):
            last = first + shorter
            result, discount = _discounted(rewards, first, last, rules.gamma)
            best_next = _maximum(q, rows[last], n_actions)
            if last == executed and terminal:
                best_next = 0.0
            _update(q, rows[first] + move + index(4 * choice), result, discount, best_next, rules)


@inlined
def _see(values, q, row, lane, lengths):
    """Copy a row of the Q-matrix to where the lane's next decision looks."""
    for action in range(4 * len(lengths)):
        values[index(action * LANES) + lane] = q[row + index(action)]


@inlined
def _act(numbers, values, q, lane, next_of, entries, reward_of, cells, moves_of, lengths, rules, rows, rewards):
    """Execute the action that a lane has chosen, and learn from it.

    Returns:
        Whether the trial has ended, and whether it did so at the final goal.
    """
    n_actions = index(4 * len(lengths))
    action = numbers[ACTION + lane]
    move = action & _3
    length = moves_of[action >> _2] if len(lengths) > 1 else 1
    row = numbers[ROW + lane]
    cell = numbers[CELL + lane]
    stage = numbers[STAGE + lane]
    moves = np.int64(numbers[MOVES + lane])
    # The return of a multi-step action by the letter of the paper: one term too many, all with the first reward.
    printed = (length > 1) & rules.printed_msa_reward

    # Move by move: a goal counts wherever it is met.
    next_row = row
    executed = 0
    result = 0.0
    discount = 1.0
    terminal = False
    going = True
    while going:
        cell = index(next_of[(cell << _2) + move])
        entry = index(entries[stage + cell])
        kind = entry & _3
        reward = reward_of[kind]
        if len(lengths) > 1:
            rows[executed] = next_row
            rewards[executed] = reward
            result += discount * (rewards[0] if printed else reward)
            discount *= rules.gamma
        else:
            result = reward
            discount = rules.gamma
        next_row = entry ^ kind
        stage += cells * (kind >> _1)
        terminal = kind == _FINAL_GOAL
        executed += 1
        met = kind >= _SUB_GOAL
        ends = terminal | (executed == length) | (moves + executed == rules.max_steps)
        going = not (ends | (met & rules.stop_at_sub_goal))
    moves += executed
    numbers[CELL + lane] = cell
    numbers[STAGE + lane] = stage
    numbers[ROW + lane] = next_row
    numbers[MOVES + lane] = index(moves)

    # The last state bootstraps unless it is terminal; the one at the step cap is not.
    best_next = _maximum(q, next_row, n_actions)
    if terminal:
        best_next = 0.0
    if len(lengths) > 1:
        result = result + discount * rewards[0] if printed else result
    _update(q, row + action, result, discount, best_next, rules)
    if len(lengths) > 1:
        rows[executed] = next_row
        _propagate(q, rows, rewards, executed, terminal, move, length, moves_of, n_actions, rules)
    # Read again, because the updates may have changed this very row.
    _see(values, q, next_row, lane, lengths)
    return terminal | (moves == rules.max_steps), terminal


@compiled
def _enter(codes, layout, first, n_actions, entries, known_codes, known_rows):
    """Fill a lane's entries; returns how many rows its Q-matrix has.

    A period meets at most n_goals · cells observations, however many codes there are. Their rows are numbered in the
    order in which the codes first occur.
    """
    mask = len(known_rows) - 1
    bits = 0
    while mask >> bits:
        bits += 1
    known_rows[:] = -1
    n_rows = 0
    for at in range(len(codes)):
        code = codes[at]
        # Codes that follow each other get places that do.
        slot = (code + (code >> bits) * 0x9E3779B1) & mask
        while known_rows[slot] >= 0 and known_codes[slot] != code:
            slot = (slot + 1) & mask
        if known_rows[slot] < 0:
            known_rows[slot] = n_rows
            known_codes[slot] = code
            n_rows += 1
        entries[at] = first + known_rows[slot] * n_actions

    n_goals = len(layout) - 1
    cells = len(codes) // n_goals
    for reached in range(n_goals):
        for goal in range(n_goals):
            at = reached * cells + layout[1 + goal]
            if goal != reached:
                entries[at] |= _OUT_OF_ORDER
            elif goal < n_goals - 1:
                # What is seen there is seen with the success counter already raised.
                entries[at] = entries[at + cells] | _SUB_GOAL
            else:
                entries[at] |= _FINAL_GOAL
    return n_rows


@compiled
def _begin_period(lanes, lane, period, codes, layout, state, n_actions, initial_q):
    """Give a lane its next period, with a fresh Q-matrix."""
    home = np.int64(lanes.numbers[HOME + lane])
    first = home * lanes.q.shape[1]
    n_rows = _enter(codes, layout, first, n_actions, lanes.entries[home], lanes.known_codes, lanes.known_rows)
    lanes.q[home, : n_rows * n_actions] = initial_q
    lanes.numbers[PERIOD + lane] = period
    for word in range(4):
        lanes.numbers[S0 + index(word * LANES) + lane] = state[word]


@compiled
def _begin_trial(numbers, values, q, entries, lane, trial, start, threshold, observations, lengths):
    """Put a lane's agent back to the start."""
    stage = numbers[HOME + lane] * observations
    entry = index(entries[stage + start])
    numbers[TRIAL + lane] = trial
    numbers[THRESHOLD + lane] = threshold[trial]
    numbers[CELL + lane] = start
    numbers[STAGE + lane] = stage
    numbers[MOVES + lane] = 0
    numbers[ROW + lane] = entry ^ (entry & _3)
    _see(values, q, numbers[ROW + lane], lane, lengths)


@compiled
def _swap(numbers, values, lane, last):
    """Let two lanes change places."""
    columns = numbers.reshape(-1, LANES)
    for column in range(len(columns)):
        columns[column, lane], columns[column, last] = columns[column, last], columns[column, lane]
    seen = values.reshape(-1, LANES)
    for action in range(len(seen)):
        seen[action, lane], seen[action, last] = seen[action, last], seen[action, lane]


@compiled_and_kept
def learn(next_cell, lengths, threshold, rules, observation, first, layout, generator, lanes, drain, steps, success):
    """Learn periods, as many side by side as there are lanes.

    The call returns when it has taken up all its periods and a lane falls free; what still runs goes on at the next
    call, with these lanes and the same arguments but for `observation`, `first` and `drain`.

    Args:
        next_cell: (4, cells) int32, transition table.
        lengths: 1 + m ints, the moves that an action of each length makes; the first is 1. A tuple, so that their
            number, and with it the number of actions, is known when the function is compiled. Action a repeats move
            a % 4 lengths[a // 4] times.
        threshold: (trials,) uint64, ε · 2^32.
        rules: see `Rules`.
        observation: (taken, n_goals, cells) int64, observation codes of the periods to take up.
        first: number of the first of them.
        layout: (periods, 1 + n_goals) int32, start and goals of all periods, distinct in a period.
        generator: (periods, 4) uint64, initial states of the random generator.
        lanes: see `Lanes`; changed.
        drain: whether to go on until no period runs.
        steps: (periods, trials) int32, written: primitive moves of every trial.
        success: (periods, trials) bool, written: whether the final goal was reached.
    """
    taken, n_goals, cells = observation.shape
    trials = steps.shape[1]
    n_actions = 4 * len(lengths)
    next_of = np.ascontiguousarray(next_cell.T).ravel()
    moves_of = np.array(lengths)
    reward_of = np.array((rules.step_reward, rules.out_of_order_reward, rules.sub_goal_reward, rules.final_goal_reward))
    # What a multi-step action has passed.
    rows = np.empty(moves_of.max() + 1, dtype=np.uint64)
    rewards = np.empty(moves_of.max(), dtype=np.float64)
    numbers, values, q, entries = lanes.numbers, lanes.values, lanes.q.ravel(), lanes.entries.ravel()
    observations = index(n_goals * cells)

    running = int(lanes.running[0])
    begun = 0
    while True:
        while running < len(lanes.q) and begun < taken:
            period = first + begun
            codes = observation[begun].ravel()
            layout_of, state = layout[period], generator[period]
            _begin_period(lanes, running, period, codes, layout_of, state, n_actions, rules.initial_q)
            start = index(layout[period, 0])
            _begin_trial(numbers, values, q, entries, running, 0, start, threshold, observations, lengths)
            running += 1
            begun += 1
        if running == 0 or not (drain or running == len(lanes.q)):
            break

        draw(numbers, running)
        choose(numbers, values, running, lengths, rules)
        lane = 0
        while lane < running:
            ended, reached = _act(
                numbers, values, q, index(lane), next_of, entries, reward_of, index(cells), moves_of, lengths, rules,
                rows, rewards,
            )  # fmt: skip
            if not ended:
                lane += 1
                continue
            trial, period = np.int64(numbers[TRIAL + index(lane)]), np.int64(numbers[PERIOD + index(lane)])
            steps[period, trial] = numbers[MOVES + index(lane)]
            success[period, trial] = reached
            if trial + 1 < trials:
                start = index(layout[period, 0])
                _begin_trial(numbers, values, q, entries, lane, trial + 1, start, threshold, observations, lengths)
                lane += 1
            else:
                # The last lane has yet to act in this turn, so it is next.
                running -= 1
                _swap(numbers, values, lane, running)
    lanes.running[0] = running
