"""Beginning and ending periods and trials in a lane."""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.compiled import compiled
from rl_design_space.learning.lanes import (
    CELL,
    FINAL_GOAL,
    HOME,
    KIND,
    LANES,
    MOVES,
    OUT_OF_ORDER,
    PERIOD,
    ROW,
    S0,
    STAGE,
    SUB_GOAL,
    THRESHOLD,
    TRIAL,
    index,
)
from rl_design_space.learning.moving import see
from rl_design_space.learning.numbering import bits_of, slot_of


@compiled
def _enter(codes, layout, first, n_actions, entries, known_codes, known_rows):
    """Fill the entries of a lane; return the number of rows of its Q-matrix.

    At most n_goals · cells observations occur in a period, however many codes there are. Rows are numbered in the order
    in which the codes first occur.
    """
    bits = bits_of(known_rows)
    known_rows[:] = -1
    n_rows = 0
    for at in range(len(codes)):
        code = codes[at]
        slot = slot_of(code, known_codes, known_rows, bits)
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
                entries[at] |= OUT_OF_ORDER
            elif goal < n_goals - 1:
                # The observation on this cell is that with the incremented success counter.
                entries[at] = entries[at + cells] | SUB_GOAL
            else:
                entries[at] |= FINAL_GOAL
    return n_rows


@compiled
def begin_period(lanes, lane, period, codes, layout, state, n_actions, initial_q, rows):
    """Begin a period in a lane, with a new Q-matrix, or with the one that is kept for it."""
    home = np.int64(lanes.numbers[HOME + lane])
    first = home * lanes.q.shape[1]
    n_rows = _enter(codes, layout, first, n_actions, lanes.entries[home], lanes.known_codes, lanes.known_rows)
    rows[period, 0] = n_rows
    if len(lanes.kept):
        lanes.q[home, : n_rows * n_actions] = lanes.kept[period, : n_rows * n_actions]
    else:
        lanes.q[home, : n_rows * n_actions] = initial_q
    lanes.numbers[PERIOD + lane] = period
    for word in range(4):
        lanes.numbers[S0 + index(word * LANES) + lane] = state[word]


@compiled
def end_period(lanes, lane, n_actions, initial_q, rows, period):
    """Count the rows of a lane's Q-matrix whose values learning has changed; keep it for the next stage, if any."""
    q = lanes.q[np.int64(lanes.numbers[HOME + lane])]
    is_kept = len(lanes.kept) > 0
    learned = 0
    for row in range(rows[period, 0]):
        changed = False
        for at in range(row * n_actions, (row + 1) * n_actions):
            changed |= q[at] != (lanes.kept[period, at] if is_kept else initial_q)
            if is_kept:
                lanes.kept[period, at] = q[at]
        learned += changed
    rows[period, 1] = learned
    if is_kept:
        for word in range(4):
            lanes.states[period, word] = lanes.numbers[S0 + index(word * LANES) + lane]


@compiled
def begin_trial(numbers, values, q, entries, lane, trial, start, threshold, observations, lengths):
    """Begin a trial: put the agent of a lane on the start."""
    stage = numbers[HOME + lane] * observations
    entry = index(entries[stage + start])
    numbers[TRIAL + lane] = trial
    numbers[THRESHOLD + lane] = threshold[trial]
    numbers[CELL + lane] = start
    numbers[STAGE + lane] = stage
    numbers[MOVES + lane] = 0
    numbers[ROW + lane] = entry & ~KIND
    see(values, q, numbers[ROW + lane], lane, lengths)


@compiled
def swap(numbers, values, lane, last):
    """Exchange two lanes."""
    columns = numbers.reshape(-1, LANES)
    for column in range(len(columns)):
        columns[column, lane], columns[column, last] = columns[column, last], columns[column, lane]
    seen = values.reshape(-1, LANES)
    for action in range(len(seen)):
        seen[action, lane], seen[action, last] = seen[action, last], seen[action, lane]
