"""The exact optimum: a lower bound for every trial."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import DesignPoint, Torus, Walled, World
from rl_design_space.learning import simulate
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import layouts
from tests.learning import strategies
from tests.learning.plays import corridor


def manhattan_tour(world: World, tour: list[int]) -> int:
    """Return the length of a shortest tour in closed form, from coordinates."""
    width, height = world.shape
    total = 0
    for origin, target in pairwise(tour):
        for difference, side in ((target % width - origin % width, width), (target // width - origin // width, height)):
            way = abs(difference)
            total += min(way, side - way) if isinstance(world, Torus) else way
    return total


@settings(deadline=None, max_examples=50)
@given(
    world_type=st.sampled_from([Torus, Walled]),
    shape=st.tuples(st.integers(2, 12), st.integers(2, 12)),
    n_goals=st.integers(1, 3),
    seed=st.integers(0, 2**32),
)
def test_breadth_first_search_finds_the_manhattan_distance(world_type, shape, n_goals, seed):
    world = world_type(size=shape)
    layout = layouts(seed, shape[0] * shape[1], n_goals, 4)
    expected = [manhattan_tour(world, tour) for tour in layout.tolist()]
    assert shortest_tours(world.next_cell(), layout).tolist() == expected


def test_a_tour_passes_the_goals_in_their_order():
    there_and_back = np.array([[2, 4, 0, 1]], dtype=np.int32)
    assert shortest_tours(corridor(5), there_and_back).tolist() == [2 + 4 + 1]


@settings(deadline=None, max_examples=50)
@given(point=strategies.points())
def test_no_trial_beats_the_optimum(point: DesignPoint):
    curves = simulate(point, threads=1)
    solved = curves.steps >= curves.optimum[:, np.newaxis]
    assert solved[curves.success].all()
    assert (curves.steps[~curves.success] == point.task.max_steps).all()


def test_a_goal_out_of_reach_is_an_error_that_names_the_period():
    one_way = corridor(4)
    one_way[1] = np.arange(4)  # moves to the left stay
    layout = np.array([[0, 1, 3], [0, 3, 1]], dtype=np.int32)
    with pytest.raises(ValueError, match=r"in period 1 no way leads through the cells \[0, 3, 1\]"):
        shortest_tours(one_way, layout)
