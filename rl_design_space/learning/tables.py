"""The tables of a design point that the kernel learns on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import ClosedLoop, DesignPoint, Outcomes, QLearning, level_of
from rl_design_space.learning.behaviour import COIN_SIDES
from rl_design_space.learning.chance import Chance, chance_of
from rl_design_space.learning.checked import action_table as action_table
from rl_design_space.learning.checked import behaviour_of as behaviour_of
from rl_design_space.learning.checked import epsilons, limits, outcomes, rewards, transitions
from rl_design_space.learning.checked import observation_codes as observation_codes
from rl_design_space.learning.initial import initial_value
from rl_design_space.learning.kernel import Rules
from rl_design_space.learning.sequential.build import method_of
from rl_design_space.learning.sequential.method import Method


class Tables(NamedTuple):
    """Tables that all periods of a design point share.

    Attributes:
        next_cell: (4, cells) int32, transitions.
        epsilon: (trials,) float64, probability of exploring; NaN if there is no schedule of it.
        threshold: (trials,) uint64, epsilon · 2^32.
        limits: the most steps of each action.
        rules: parameters of the learner, and rewards.
        outcomes: what steps may lead to; None if there is no chance in it.
        chance: the same as the kernel reads it.
        method: learner, behaviour and step sizes; None for Q-learning with constant α and ε-greedy behaviour.
    """

    next_cell: NDArray[np.int32]
    epsilon: FloatArray
    threshold: NDArray[np.uint64]
    limits: tuple[int, ...]
    rules: Rules
    method: Method | None = None
    outcomes: Outcomes | None = None
    chance: Chance | None = None

    @property
    def n_outcomes(self) -> int:
        """The most outcomes of a step."""
        return 1 if self.outcomes is None else self.outcomes.cells.shape[-1]


def learning_tables(point: DesignPoint) -> Tables:
    """Return the tables of a point.

    Raises:
        ConfigError: an option returns a table of the wrong shape, type or range.
    """
    levels = epsilons(point)
    # Without a schedule of ε there is no number for a trial that all periods share.
    scheduled = level_of(point.exploration) == "epsilon" and not isinstance(point.exploration, ClosedLoop)
    epsilon = levels if scheduled else np.full(len(levels), np.nan)
    threshold = np.rint(np.nan_to_num(epsilon) * COIN_SIDES).astype(np.uint64)
    limit_of, rules = tuple(limits(point).tolist()), _rules(point, rewards(point))
    found = outcomes(point)
    return Tables(
        transitions(point),
        epsilon,
        threshold,
        limit_of,
        rules,
        method_of(point, levels),
        found,
        found and chance_of(*found, tabulated=not point.msa.repeats),
    )


def _rules(point: DesignPoint, table: FloatArray) -> Rules:
    learner, msa = point.learner, point.msa
    step, sub_goal, final_goal = table.tolist()
    return Rules(
        alpha=learner.alpha,
        gamma=learner.gamma,
        initial_q=initial_value(point),
        step_reward=step,
        sub_goal_reward=sub_goal,
        final_goal_reward=final_goal,
        out_of_order_reward=step if learner.out_of_order == "step_reward" else 0.0,
        explore_all=learner.explore == "all",
        first_maximum=learner.ties == "first",
        printed_update=isinstance(learner, QLearning) and learner.update == "printed",
        printed_msa_reward=msa.reward == "printed",
        stop_at_sub_goal=msa.sub_goal == "stop",
        propagated_lengths=msa.propagated_lengths,
        consistent=msa.propagation == "consistent",
        max_steps=point.task.max_steps,
    )
