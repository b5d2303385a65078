"""Beginning and ending periods and trials in a lane."""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.action_tables import enter_controls
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
    row_width,
)
from rl_design_space.learning.moving import see
from rl_design_space.learning.numbering import bits_of, slot_of


@compiled
def number(codes, first, stride, numbered, known_codes, known_rows):
    """Number codes in the order in which they first occur: first, first + stride, …; return how many codes there are.

    At most n_goals · cells observations occur in a period, however many codes there are.
    """
    bits = bits_of(known_rows)
    known_rows[:] = -1
    count = 0
    for at in range(len(codes)):
        code = codes[at]
        slot = slot_of(code, known_codes, known_rows, bits)
        if known_rows[slot] < 0:
            known_rows[slot] = count
            known_codes[slot] = code
            count += 1
        numbered[at] = first + known_rows[slot] * stride
    return count


@compiled
def _mark_goals(layout, entries):
    """Add the kinds of cells to the entries of a lane."""
    n_goals = len(layout) - 1
    cells = len(entries) // n_goals
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


@compiled
def begin_period(lanes, lane, period, codes, layout, state, limits, initial_q, rows, taken, table, earnings):
    """Begin a period in a lane, with a new Q-matrix, or with the one that is given."""
    home = np.int64(lanes.numbers[HOME + lane])
    first = home * lanes.q.shape[1]
    width = row_width(len(limits))
    entries = lanes.entries[home]
    n_rows = number(codes, first, width, entries, lanes.known_codes, lanes.known_rows)
    if table is not None:
        marks = np.empty(len(codes), dtype=np.uint32)
        number(table.marks[taken], 0, 1, marks, lanes.known_codes, lanes.known_rows)
        enter_controls(table.controls[taken], marks, entries, first, lanes.controls[home])
    if earnings is not None:
        for at in range(earnings.shape[1]):
            lanes.earnings[home, at] = earnings[taken, at]
    _mark_goals(layout, entries)
    rows[period, 0] = n_rows
    q = lanes.q[home]
    if len(lanes.given):
        given = lanes.given[period]
        for at in range(n_rows * width):
            q[at] = given[at]
    else:
        q[: n_rows * width] = initial_q
    lanes.numbers[PERIOD + lane] = period
    for word in range(4):
        lanes.numbers[S0 + index(word * LANES) + lane] = state[word]


@compiled
def end_period(lanes, lane, limits, initial_q, rows, period):
    """Count the rows of a lane's Q-matrix whose values learning has changed; keep what the next stage needs, if any."""
    q = lanes.q[np.int64(lanes.numbers[HOME + lane])]
    width, n_rows, is_given = row_width(len(limits)), rows[period, 0], len(lanes.given) > 0
    learned = 0
    for row in range(n_rows):
        changed = False
        for at in range(row * width, (row + 1) * width):
            changed |= q[at] != (lanes.given[period, at] if is_given else initial_q)
        learned += changed
    rows[period, 1] = learned
    if len(lanes.kept):
        kept = lanes.kept[period]
        for at in range(n_rows * width):
            kept[at] = q[at]
    if len(lanes.states):
        for word in range(4):
            lanes.states[period, word] = lanes.numbers[S0 + index(word * LANES) + lane]


@compiled
def begin_trial(numbers, values, q, entries, lane, trial, start, threshold, observations, limits):
    """Begin a trial: put the agent of a lane on the start."""
    stage = numbers[HOME + lane] * observations
    entry = index(entries[stage + start])
    numbers[TRIAL + lane] = trial
    numbers[THRESHOLD + lane] = threshold[trial]
    numbers[CELL + lane] = start
    numbers[STAGE + lane] = stage
    numbers[MOVES + lane] = 0
    numbers[ROW + lane] = entry & ~KIND
    see(values, q, numbers[ROW + lane], lane, limits)


@compiled
def swap(numbers, values, lane, last):
    """Exchange two lanes."""
    columns = numbers.reshape(-1, LANES)
    for column in range(len(columns)):
        columns[column, lane], columns[column, last] = columns[column, last], columns[column, lane]
    seen = values.reshape(-1, LANES)
    for action in range(len(seen)):
        seen[action, lane], seen[action, last] = seen[action, last], seen[action, lane]
