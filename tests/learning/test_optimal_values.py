"""Optimal Q-values: by hand, by the shortest tour, and as the values that the learner converges to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import Torus, Walled
from rl_design_space.errors import ConfigError
from rl_design_space.learning.optimal_values import optimal_values
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import layouts
from tests.learning.plays import play

MANY_REWARDS, END_REWARD = np.array([-0.1, 1.0, 10.0]), np.array([0.0, 0.0, 10.0])


def test_values_by_hand():
    # 2×2 cells, the goal in the last one: right and left lead to the same cell, and so do above and below.
    values = optimal_values(Torus(size=2).next_cell(), np.array([3], dtype=np.int32), MANY_REWARDS, 0.9, -0.1)
    far, beside = -0.1 + 0.9 * 10, -0.1 + 0.9 * (-0.1 + 0.9 * 10)
    assert values[0, 0, :3] == pytest.approx([far, beside, 10])
    assert values[2, 0, :3] == pytest.approx([far, 10, beside])
    assert (values[0] == values[1]).all()


def test_a_sub_goal_leads_to_the_values_of_the_next_counter():
    values = optimal_values(Torus(size=2).next_cell(), np.array([1, 3], dtype=np.int32), MANY_REWARDS, 0.9, 0.5)
    # From cell 0 right onto the due goal 1, then below; the goal that is not due yet is worth a detour by its reward.
    assert values[0, 0, 0] == pytest.approx(1 + 0.9 * 10)
    assert values[3, 0, 2] == pytest.approx(-0.1 + 0.9 * values[0, 0, 0])
    assert values[0, 0, 2] == pytest.approx(0.5 + 0.9 * values[2, 0, 3])


@settings(deadline=None, max_examples=50)
@given(
    world=st.builds(
        lambda kind, dx, dy: kind(size=(dx, dy)), st.sampled_from([Torus, Walled]), st.integers(2, 7), st.integers(2, 7)
    ),
    n_goals=st.integers(1, 3),
    seed=st.integers(0, 2**32),
    gamma=st.floats(0.1, 0.95),
)
def test_with_an_end_reward_the_best_value_counts_the_shortest_tour(world, n_goals, seed, gamma):
    layout = layouts(seed, world.next_cell().shape[1], n_goals, 3)
    values = optimal_values(world.next_cell(), layout[:, 1:], END_REWARD, gamma, 0.0)
    at_start = values.max(axis=0)[np.arange(3), 0, layout[:, 0]]
    assert at_start == pytest.approx(10 * gamma ** (shortest_tours(world.next_cell(), layout) - 1.0))


def test_the_learner_converges_to_them():
    world, layout = Torus(size=3), [0, 4, 8]
    rewards = {"step_reward": -0.1, "sub_goal_reward": 1.0, "final_goal_reward": 10.0, "out_of_order_reward": 0.3}
    learned = play(world.next_cell(), layout, epsilon=1.0, trials=400, gamma=0.9, **rewards).q
    values = optimal_values(world.next_cell(), np.array(layout[1:], dtype=np.int32), MANY_REWARDS, 0.9, 0.3)
    states = [counter * 9 + cell for counter, goal in enumerate(layout[1:]) for cell in range(9) if cell != goal]
    assert learned[states] == pytest.approx(values.reshape(4, -1).T[states])


def test_values_without_a_discount_are_refused():
    with pytest.raises(ConfigError, match=r"learner\.gamma=1\.0: should be below 1"):
        optimal_values(Torus(size=2).next_cell(), np.array([3], dtype=np.int32), MANY_REWARDS, 1.0, -0.1)
