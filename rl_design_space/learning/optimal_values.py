"""The exact optimal Q-values of the task, by dynamic programming."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError

#: Values are final when a sweep changes none of them by more than this, relative to the largest.
_TOLERANCE = 1e-13


def optimal_values(
    next_cell: NDArray[np.int32], goals: NDArray[np.int32], rewards: FloatArray, gamma: float, out_of_order: float
) -> FloatArray:
    """Return the optimal Q-values of every step in every state of a layout.

    Q*(s, c, a) = r + γ · max Q*(s', c', ·) for the step a from cell c at success counter s, which leads to cell c': on
    the due goal s the counter increases, and the state after the final goal is worth 0. The values at one counter
    follow from those at the next one, so counters are solved from the last to the first, each by value iteration.

    Args:
        next_cell: (4, cells) transition table.
        goals: (..., n_goals) cells, to be reached in this order.
        rewards: (3,) of a step, of reaching the due sub-goal, and of reaching the final goal.
        gamma: discount factor, below 1.
        out_of_order: reward of a step onto a goal that is not due.

    Returns:
        (4, ..., n_goals, cells), by direction, success counter and cell.

    Raises:
        ConfigError: the discount factor is 1, with which values may be infinite.
    """
    if not 0 <= gamma < 1:
        raise ConfigError.at("learner.gamma", gamma, "should be below 1: otherwise optimal values may be infinite")
    *many, n_goals = goals.shape
    layouts, cells = goals.reshape(-1, n_goals), next_cell.shape[1]
    step, sub_goal, final_goal = rewards.tolist()
    values = np.empty((len(next_cell), len(layouts), n_goals, cells))
    best = np.zeros((len(layouts), cells))
    for due in reversed(range(n_goals)):
        row = np.arange(len(layouts))[:, np.newaxis]
        onto = np.full((len(layouts), cells), step)  # reward by the cell that a step leads to
        onto[row, layouts] = out_of_order
        goal = layouts[:, due]
        onto[row[:, 0], goal] = final_goal if due == n_goals - 1 else sub_goal + gamma * best[row[:, 0], goal]
        going_on = np.ones((len(layouts), cells))
        going_on[row[:, 0], goal] = 0
        values[:, :, due], best = _solved(next_cell, onto, gamma * going_on)
    return values.reshape(len(next_cell), *many, n_goals, cells)


def _solved(next_cell: NDArray[np.int32], onto: FloatArray, discount: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the Q-values, (4, layouts, cells), and the values, (layouts, cells), of one success counter.

    Args:
        next_cell: (4, cells)
        onto: (layouts, cells) what a step onto a cell is worth, beside the discounted value of that cell.
        discount: (layouts, cells) discount of the value of that cell.
    """
    best = np.zeros_like(onto)
    while True:
        values = (onto + discount * best)[:, next_cell].transpose(1, 0, 2)
        before, best = best, values.max(axis=0)
        if np.abs(best - before).max() <= _TOLERANCE * max(1.0, np.abs(best).max()):
            return values, best
