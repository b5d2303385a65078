"""Rewards by transition: of shaping by a potential, and of rewards that depend on the state and the step."""

from __future__ import annotations

import numpy as np

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space.design import DesignPoint, PotentialReward, Reward, TransitionReward
from rl_design_space.learning.checked import by_transition, potential
from rl_design_space.learning.tables import Tables


def is_paid(reward: Reward) -> bool:
    """Return whether rewards depend on the transition, not on the kind of the cell alone."""
    return isinstance(reward, (PotentialReward, TransitionReward))


def earnings(point: DesignPoint, tables: Tables, goals: IntArray) -> FloatArray | None:
    """Return the rewards of several periods in the form in which the kernel reads them; None if none are needed.

    Args:
        point: the design point.
        tables: of the point.
        goals: (periods, n_goals) cells.

    Returns:
        (periods, n_goals · cells · width · k), see `chance.Pay`.

    Raises:
        ConfigError: the reward returns arrays of the wrong shape, type or range.
    """
    if not is_paid(point.reward):
        return None
    (periods, n_goals), cells = goals.shape, tables.next_cell.shape[1]
    width, k = (4 if point.msa.repeats else 8), tables.n_outcomes
    table = np.zeros((periods, n_goals, cells, width, k))
    if periods:
        found = np.moveaxis(rewards_by_transition(point, tables, goals), 2, 3)[..., :width, :]
        table[..., : found.shape[-2], :] = found
    return table.reshape(periods, n_goals * cells * width * k)


def width_of(table: FloatArray | None) -> int:
    """Return the number of rewards of a period."""
    return 0 if table is None else table.shape[1]


def rewards_by_transition(point: DesignPoint, tables: Tables, goals: IntArray) -> FloatArray:
    """Return the reward of each step in each state, by outcome: (periods, n_goals, 5, cells, k); the fifth is to wait.

    It is the reward of the kind of cell that the step leads to, plus that of the transition, plus γ·Φ(s') - Φ(s).

    Args:
        point: the design point.
        tables: of the point.
        goals: (periods, n_goals) cells.

    Raises:
        ConfigError: the reward returns arrays of the wrong shape, type or range.
    """
    there = tables.next_cell[..., np.newaxis] if tables.outcomes is None else tables.outcomes.cells
    _, cells, k = there.shape
    waiting = np.broadcast_to(np.arange(cells, dtype=np.int32)[:, np.newaxis], (1, cells, k))
    there = np.concatenate([there, waiting])
    found = _by_kind(tables, goals, cells)[..., there]
    if (more := by_transition(point, goals, k)) is not None:
        found[:, :, :4] += more
    if (height := potential(point, goals)) is not None:
        shaping = tables.rules.gamma * _arriving(height, goals)[..., there]
        shaping -= height[:, :, np.newaxis, :, np.newaxis]
        found += shaping
    return found


def _by_kind(tables: Tables, goals: IntArray, cells: int) -> FloatArray:
    """Return the reward of arriving on a cell, (periods, n_goals, cells), by the success counter before."""
    rules, (periods, n_goals) = tables.rules, goals.shape
    found = np.full((periods, n_goals, cells), rules.step_reward)
    row = np.arange(periods)
    for due in range(n_goals):
        found[row[:, np.newaxis], due, goals] = rules.out_of_order_reward
        found[row, due, goals[:, due]] = rules.final_goal_reward if due == n_goals - 1 else rules.sub_goal_reward
    return found


def _arriving(height: FloatArray, goals: IntArray) -> FloatArray:
    """Return the potential of the state after arriving on a cell, by the success counter before."""
    found, row = height.copy(), np.arange(len(goals))
    n_goals = goals.shape[1]
    for due in range(n_goals):
        goal = goals[:, due]
        found[row, due, goal] = height[row, due + 1, goal] if due + 1 < n_goals else 0.0
    return found
