"""A design point as the tables that the kernel learns on, checked, because compiled code trusts its indices."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space.design import DesignPoint, cell_count
from rl_design_space.learning.behaviour import COIN_SIDES
from rl_design_space.learning.kernel import Rules


class Tables(NamedTuple):
    """What all periods of a design point share.

    Attributes:
        next_cell: (4, cells) int32, transitions.
        epsilon: (trials,) float64, probability of exploring.
        threshold: (trials,) uint64, the same in steps of 2^-32.
        lengths: moves of every action length, the first is 1.
        rules: of the learner.
    """

    next_cell: NDArray[np.int32]
    epsilon: FloatArray
    threshold: NDArray[np.uint64]
    lengths: tuple[int, ...]
    rules: Rules


def learning_tables(point: DesignPoint) -> Tables:
    """The tables of a point.

    Raises:
        ValueError: an option yields a table of the wrong shape, type or range.
    """
    cells = cell_count(point.world)
    next_cell = point.world.next_cell()
    _check("world.next_cell()", next_cell, (4, cells), np.int32, 0, cells - 1)
    epsilon = point.exploration.schedule(point.task.trials)
    _check("exploration.schedule()", epsilon, (point.task.trials,), np.float64, 0, 1)
    rewards = point.reward.table()
    _check("reward.table()", rewards, (3,), np.float64, -np.finfo(float).max, np.finfo(float).max)
    lengths = tuple(point.msa.action_lengths().tolist())
    threshold = np.rint(epsilon * COIN_SIDES).astype(np.uint64)
    return Tables(next_cell, epsilon, threshold, lengths, _rules(point, rewards))


def observation_codes(point: DesignPoint, goals: IntArray) -> NDArray[np.int64]:
    """What the agent observes in some periods.

    Args:
        point: whose representation is used.
        goals: (periods, n_goals).

    Returns:
        (periods, n_goals, cells) int64 codes, contiguous, by success counter and cell.

    Raises:
        ValueError: the representation yields codes of the wrong shape, type or range.
    """
    codes = point.representation.observation(point.world, goals)
    _check("representation.observation()", codes, (*goals.shape, cell_count(point.world)), np.int64, 0, 2**63 - 1)
    return np.ascontiguousarray(codes)


def _check(name: str, table: object, shape: tuple[int, ...], dtype: type[np.generic], low: Any, high: Any) -> None:
    wanted = f"{name} should give {np.dtype(dtype)} of shape {shape}"
    if not isinstance(table, np.ndarray) or table.shape != shape or table.dtype != dtype:
        found = f"{table.dtype} of shape {table.shape}" if isinstance(table, np.ndarray) else type(table).__name__
        raise ValueError(f"{wanted}, not {found}")
    if not (table.min() >= low and table.max() <= high):  # no number at all is neither
        raise ValueError(f"{wanted}, all from {low} to {high}; it gives {table.min()} to {table.max()}")


def _rules(point: DesignPoint, rewards: FloatArray) -> Rules:
    learner, msa = point.learner, point.msa
    step, sub_goal, final_goal = rewards.tolist()
    propagated = {"none": 0, "primitives": 1, "all_shorter": 1 + len(msa.lengths)}
    return Rules(
        alpha=learner.alpha,
        gamma=learner.gamma,
        initial_q=learner.initial_q,
        step_reward=step,
        sub_goal_reward=sub_goal,
        final_goal_reward=final_goal,
        out_of_order_reward=step if learner.out_of_order == "step_reward" else 0.0,
        explore_all=learner.explore == "all",
        first_maximum=learner.ties == "first",
        printed_update=learner.update == "printed",
        printed_msa_reward=msa.reward == "printed",
        stop_at_sub_goal=msa.sub_goal == "stop",
        propagated_lengths=propagated[msa.propagation],
        max_steps=point.task.max_steps,
    )
