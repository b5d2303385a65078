"""Learning single periods, of a design point or of tables built by hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rl_design_space.design import DesignPoint
from rl_design_space.learning.behaviour import COIN_SIDES
from rl_design_space.learning.earning import earnings, width_of
from rl_design_space.learning.kernel import Rules, learn
from rl_design_space.learning.lanes import empty_lanes, row_width
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import action_table, learning_tables, observation_codes

#: The learner of a test that says nothing else of it: a Q-value becomes its undiscounted target.
PLAIN = Rules(
    alpha=1.0,
    gamma=1.0,
    initial_q=0.0,
    step_reward=-1.0,
    sub_goal_reward=4.0,
    final_goal_reward=8.0,
    out_of_order_reward=-1.0,
    explore_all=True,
    first_maximum=True,
    printed_update=False,
    printed_msa_reward=False,
    stop_at_sub_goal=False,
    propagated_lengths=0,
    consistent=False,
    max_steps=1000,
)


class Play(NamedTuple):
    steps: list[int]
    success: list[bool]
    q: np.ndarray


def corridor(cells: int) -> np.ndarray:
    """Return the transition table of cells in a line; steps up, down and against the ends have no effect."""
    cell = np.arange(cells, dtype=np.int32)
    return np.array([np.minimum(cell + 1, cells - 1), np.maximum(cell - 1, 0), cell, cell], dtype=np.int32)


def word_for(action: int, n_actions: int) -> int:
    """Return a random word whose lower half selects this action among all."""
    return -(-action * COIN_SIDES // n_actions)


def state_yielding(word: int) -> list[int]:
    """Return the state of a generator whose first word is this one: rotl(s0 + s3, 23) + s0 with s3 = -s0."""
    return [word, 1, 2, -word % 2**64]


def play(
    next_cell, layout, *, observation=None, lengths=(1,), epsilon=0.0, trials=1, state=(1, 2, 3, 4), **rules
) -> Play:
    """Learn one period on tables; by default every (counter, cell) has its own row of the Q-matrix."""
    n_goals, cells = len(layout) - 1, next_cell.shape[1]
    if observation is None:
        observation = np.arange(n_goals * cells).reshape(n_goals, cells)
    codes = np.asarray(observation, dtype=np.int64)[np.newaxis]
    threshold = np.full(trials, round(epsilon * COIN_SIDES), dtype=np.uint64)
    return _learn(next_cell, codes, layout, threshold, np.repeat(lengths, 4).tolist(), PLAIN._replace(**rules), state)


def play_period(point: DesignPoint, period: int) -> tuple[Play, np.ndarray]:
    """Learn one period of a point; return the result and the observation codes of the rows of its Q-matrix."""
    layout = layouts_of(point)[period]
    codes = observation_codes(point, layout[np.newaxis, 1:])
    tables = learning_tables(point)
    table = action_table(point, layout[np.newaxis, 1:], codes)
    state = behaviour_states(point.seed, point.task.periods)[period]
    paid = earnings(point, tables, layout[np.newaxis, 1:])
    played = _learn(
        tables.next_cell, codes, layout, tables.threshold, tables.limits, tables.rules, state, table, tables.chance,
        paid, tables.method,
    )  # fmt: skip
    return played, np.unique(codes)


def _learn(
    next_cell, codes, layout, threshold, limits, rules, state, table=None, chance=None, paid=None, method=None
) -> Play:
    # Read-only or not as in a simulation: the kernel would be compiled again for other types.
    generator, layout = np.array([state], dtype=np.uint64), np.array([layout], dtype=np.int32)
    generator.setflags(write=False)
    limits = tuple(limits)
    lanes = empty_lanes(
        1, codes.size, limits, tabulated=table is not None, drawn=chance is not None, earnings=width_of(paid)
    )
    steps = np.empty((1, len(threshold)), dtype=np.int32)
    success = np.empty((1, len(threshold)), dtype=np.bool_)
    rows = np.empty((1, 2), dtype=np.int32)
    learn(
        next_cell, limits, threshold, rules, codes, 0, layout, generator, lanes, True, steps, success, rows, table,
        None, chance, paid, method,
    )  # fmt: skip
    # The learner numbers rows as their codes occur; here they go by the codes' values.
    _, occurs = np.unique(codes, return_index=True)
    row_of = np.argsort(np.argsort(occurs))
    q = lanes.q.reshape(-1, row_width(len(limits)))[row_of, : len(limits)]
    return Play(steps[0].tolist(), success[0].tolist(), np.ascontiguousarray(q))
