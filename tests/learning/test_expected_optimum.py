"""The optimum of stochastic worlds: the fewest steps that can be expected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.analysis.learning_curves import random_walk_steps
from rl_design_space.analysis.properties import optimal_moves
from rl_design_space.design import Controllers, DesignPoint, Direct, Direction, Outcomes, Slip, Task, Torus, Wind
from rl_design_space.errors import ConfigError
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.memoryless import memoryless_steps
from rl_design_space.learning.optimum import (
    expected_steps,
    expected_tours,
    luckiest_tours,
    optimal_steps,
    shortest_tours,
)
from rl_design_space.learning.tables import learning_tables
from tests.learning import strategies


@settings(deadline=None, max_examples=30)
@given(world=strategies.worlds, data=st.data())
def test_without_chance_it_is_that_of_breadth_first_search(world, data):
    next_cell = world.next_cell()
    cell = st.integers(0, next_cell.shape[1] - 1)
    layout = np.array([data.draw(st.lists(cell, min_size=2, max_size=4))], dtype=np.int32)
    certain = Outcomes(next_cell[..., np.newaxis], np.ones((*next_cell.shape, 1)))
    assert expected_tours(certain, layout).tolist() == shortest_tours(next_cell, layout).tolist()


@pytest.mark.parametrize("p", [0.1, 0.5, 0.95])
def test_a_step_that_may_be_lost_takes_longer_by_the_same_factor(p: float):
    distances = np.abs(np.stack(Torus(size=7).offset(np.arange(49)))).sum(axis=0)
    found = expected_steps(Slip(size=7, p=p, astray="stays").outcomes(), np.arange(49, dtype=np.int32))
    np.testing.assert_allclose(found, distances / (1 - p), rtol=1e-12)


@pytest.mark.parametrize("world", [Slip(size=(4, 3), p=0.4), Slip(size=4, border="walled", p=0.7), Wind(size=5)])
def test_no_policy_needs_fewer_steps_and_one_needs_as_many(world):
    """The greedy policy is evaluated by solving its linear system, and no single change of it is better."""
    cells, probabilities = world.outcomes()
    count = cells.shape[1]
    goal = 5
    steps = expected_steps(world.outcomes(), np.array([goal]))[0]
    by_step = 1 + (probabilities * steps[cells]).sum(axis=-1)
    chosen = by_step.argmin(axis=0)
    walk = np.zeros((count, count))
    for cell in range(count):
        np.add.at(walk[cell], cells[chosen[cell], cell], probabilities[chosen[cell], cell])
    others = np.arange(count) != goal
    exact = np.linalg.solve((np.eye(count) - walk)[np.ix_(others, others)], np.ones(count - 1))
    np.testing.assert_allclose(steps[others], exact, rtol=1e-11)
    np.testing.assert_allclose(by_step.min(axis=0)[others], steps[others], rtol=1e-11)


def test_a_goal_that_is_reached_by_luck_alone_is_refused():
    # Of three cells, every step from the first leads to the goal or into a trap.
    cells = np.tile(np.array([[[1, 2], [1, 1], [2, 2]]], dtype=np.int32), (4, 1, 1))
    outcomes = Outcomes(cells, np.full((4, 3, 2), 0.5))
    assert expected_steps(outcomes, np.array([1])).tolist() == [[np.inf, 0, np.inf]]
    with pytest.raises(ConfigError, match=r"in period 0 no policy is sure to pass the cells \[0, 1\] in this order"):
        expected_tours(outcomes, np.array([[0, 1]], dtype=np.int32))


def test_luck_may_need_fewer_steps_than_are_expected():
    point = DesignPoint(world=Slip(p=0.5), task=Task(periods=20))
    tables, layouts = learning_tables(point), layouts_of(point)
    assert (luckiest_tours(tables, layouts) < optimal_steps(tables, layouts)).all()
    straight = shortest_tours(tables.next_cell, layouts)
    assert (luckiest_tours(tables, layouts) <= straight).all()


def test_a_random_walk_takes_no_notice_of_slips_to_all_sides():
    layouts = layouts_of(DesignPoint(task=Task(periods=5)))
    plain = random_walk_steps(Torus(), layouts)
    assert random_walk_steps(Slip(p=0.6, astray="others"), layouts) == pytest.approx(plain, rel=1e-9)
    assert random_walk_steps(Slip(p=0.5, astray="stays"), layouts) == pytest.approx(2 * plain, rel=1e-9)


def test_memoryless_policies_are_known_where_they_can_be_any():
    point = DesignPoint(world=Slip(size=4), task=Task(goals=2, periods=3), representation=Direct())
    layouts = layouts_of(point)
    np.testing.assert_array_equal(memoryless_steps(point, layouts), optimal_steps(learning_tables(point), layouts))
    assert np.isnan(memoryless_steps(replace(point, representation=Direction()), layouts)).all()
    alone = replace(point, msa=Controllers(primitives=False))
    assert np.isnan(memoryless_steps(alone, layouts)).all()


def test_what_is_known_without_chance_only_is_refused_by_name():
    with pytest.raises(ConfigError, match="world: Slip is stochastic; the steps that bring the agent nearer"):
        optimal_moves(Slip(), np.array([3], dtype=np.int32))
