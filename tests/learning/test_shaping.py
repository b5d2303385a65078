"""Potential-based shaping: the optimal policy stays the same, and steps of multi-step actions add up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from rl_design_space.design import (
    DesignPoint,
    GoalReward,
    MultiStepActions,
    QLearning,
    ShapedReward,
    Slip,
    Task,
    Torus,
    Walled,
    Wind,
)
from rl_design_space.learning.earning import rewards_by_transition
from rl_design_space.learning.optimal_values import optimal_values
from rl_design_space.learning.tables import learning_tables

GOALS = np.array([[3, 11, 6]], dtype=np.int32)
SHAPINGS = ["straight_way", "due_goal", "all_goals", "goals_reached"]


def q_values(point: DesignPoint) -> np.ndarray:
    """Return the optimal Q-values, (n_goals, 4, cells), by value iteration on rewards and outcomes."""
    tables, goals = learning_tables(point), GOALS[0]
    rewards = rewards_by_transition(point, tables, GOALS)[0, :, :4]
    there = tables.next_cell[..., np.newaxis] if tables.outcomes is None else tables.outcomes.cells
    shares = np.ones(there.shape) if tables.outcomes is None else tables.outcomes.probabilities
    values = np.zeros((len(goals) + 1, there.shape[1]))  # of the states after the last goal: 0
    for _ in range(600):
        arriving = values[:-1].copy()
        for counter, goal in enumerate(goals):
            arriving[counter, goal] = values[counter + 1, goal]
        q = (shares * (rewards + tables.rules.gamma * arriving[:, there])).sum(axis=-1)
        values[:-1] = q.max(axis=1)
    return q


@pytest.mark.parametrize("world", [Torus(size=4), Slip(size=4, p=0.3), Wind(size=4, strengths=(0, 1))], ids=str)
@pytest.mark.parametrize("shaping", SHAPINGS)
@pytest.mark.parametrize("out_of_order", ["step_reward", "zero"])
def test_the_optimal_policy_stays_the_same(world, shaping: str, out_of_order: str):
    """Q-values differ by the potential alone, so the order of actions is the same in every state."""
    plain = DesignPoint(world=world, learner=QLearning(out_of_order=out_of_order))
    shaped = replace(plain, reward=ShapedReward(shaping=shaping, weight=0.7))
    height = shaped.reward.potential(world, GOALS)[0]
    np.testing.assert_allclose(q_values(shaped) + height[:, np.newaxis], q_values(plain), atol=1e-9)


def test_rewards_without_shaping_are_those_of_the_task():
    point = DesignPoint(world=Torus(size=4))
    expected = optimal_values(point.world.next_cell(), GOALS, point.reward.table(), 0.9, -0.1)[:, 0]
    np.testing.assert_allclose(q_values(point).swapaxes(0, 1), expected, atol=1e-9)


def test_the_potential_of_the_straight_way_is_the_optimal_value_where_nothing_is_in_the_way():
    reward = ShapedReward()
    for world in (Torus(size=5), Walled(size=(6, 4))):
        values = optimal_values(world.next_cell(), GOALS, reward.table(), 0.9, -0.1).max(axis=0)
        height = reward.potential(world, GOALS)
        going_on = np.ones(height.shape, dtype=bool)
        going_on[0, np.arange(3), GOALS[0]] = False  # there the counter would have increased
        np.testing.assert_allclose(height[going_on], values[going_on], atol=1e-9)


def test_distances_lead_to_the_due_goal_or_through_all():
    world, goals = Walled(size=(5, 1 + 1)), np.array([4, 2, 0])
    assert ShapedReward(shaping="due_goal").potential(world, goals)[0, :5].tolist() == [-4, -3, -2, -1, 0]
    assert ShapedReward(shaping="all_goals").potential(world, goals)[:, 0].tolist() == [-8, -4, 0]
    assert ShapedReward(shaping="goals_reached", weight=2.0).potential(world, goals)[:, 0].tolist() == [0, 2, 4]


def test_the_return_as_printed_is_refused():
    with pytest.raises(ValidationError, match=r"msa\.reward=printed: .* use msa\.reward=realised"):
        DesignPoint(reward=ShapedReward(), msa=MultiStepActions(lengths=(2,), reward="printed"))
    assert DesignPoint(reward=GoalReward(), msa=MultiStepActions(lengths=(2,), reward="printed"), task=Task())
