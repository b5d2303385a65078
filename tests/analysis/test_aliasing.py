"""Perceptual aliasing: by hand on small worlds, and what must hold of any representation."""

from __future__ import annotations

from math import log2

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.analysis.aliasing import Aliasing, aliasing, aliasing_by_layout
from rl_design_space.design import AdHoc, Direct, Direction, Distance, GoalReward, QLearning, Torus
from rl_design_space.learning.optimal_values import optimal_values
from rl_design_space.learning.streams import layouts

REWARDS = np.array([-0.1, 1.0, 10.0])


def of_codes(codes, goals, size: int) -> Aliasing:
    world, goals = Torus(size=size), np.array(goals, dtype=np.int32)
    values = optimal_values(world.next_cell(), goals, REWARDS, 0.9, -0.1)
    return aliasing(world, goals, np.asarray(codes, dtype=np.int64), values)


def of(representation, goals, size: int) -> Aliasing:
    return of_codes(representation.observation(Torus(size=size), np.array(goals)), goals, size)


def test_distance_on_2_by_2_cells():
    # Goal in cell 3. Cell 0 is at distance 2, cells 1 and 2 are at distance 1: from them each step leads once to the
    # goal and once to cell 0, so one bit is unknown in two of three states.
    found = of(Distance(), [3], 2)
    assert found.next_unknown == pytest.approx(2 / 3)
    assert found.shared == pytest.approx(2 / 3)
    # Right is worth 8.9 in cell 0, 7.91 in cell 1 and 10 in cell 2; merged, the last two are worth 8.955.
    values = np.array([8.9, 7.91, 10.0])
    assert found.value_lost == pytest.approx(2 * 1.045**2 / np.square(values - values.mean()).sum())


def test_direction_on_3_by_3_cells():
    # Goal in the middle. Three cells see it on the right, three on the left, one above and one below. A step towards it
    # leads from three cells to three observations; any other step to one.
    found = of(Direction(), [4], 3)
    assert found.shared == pytest.approx(6 / 8)
    assert found.next_unknown == pytest.approx(2 / 4 * 3 / 8 * log2(3))


def test_a_single_observation_leaves_no_value_but_the_mean():
    found = of_codes(np.zeros((1, 9)), [4], 3)
    assert found.value_lost == pytest.approx(1)
    assert found.shared == 1
    # Each step ends the trial in one of eight states.
    assert found.next_unknown == pytest.approx(-(1 / 8 * log2(1 / 8) + 7 / 8 * log2(7 / 8)))


def test_the_counter_alone_tells_the_goals_apart():
    # Two goals on 2×2 cells: three states at each counter, all alike; one step in three leads on.
    found = of_codes([[0] * 4, [1] * 4], [1, 2], 2)
    assert found.shared == 1
    assert found.next_unknown == pytest.approx(-(1 / 3 * log2(1 / 3) + 2 / 3 * log2(2 / 3)))


codes = st.integers(2, 4).flatmap(
    lambda size: st.tuples(
        st.just(size),
        st.lists(st.integers(0, size * size - 1), min_size=1, max_size=3, unique=True),
        st.randoms(use_true_random=False),
    )
)


@settings(deadline=None, max_examples=60)
@given(codes)
def test_observations_of_ones_own_alias_nothing(drawn):
    size, goals, random = drawn
    states = len(goals) * size * size
    own = np.array(random.sample(range(10 * states), states)).reshape(len(goals), -1)
    assert of_codes(own, goals, size) == Aliasing(0, 0, 0)


@settings(deadline=None, max_examples=60)
@given(codes)
def test_names_of_observations_do_not_matter_and_merging_them_loses_more(drawn):
    size, goals, random = drawn
    few = np.array([random.randrange(6) for _ in range(len(goals) * size * size)]).reshape(len(goals), -1)
    found = of_codes(few, goals, size)
    names = np.array(random.sample(range(100), 6))
    assert of_codes(names[few], goals, size) == pytest.approx(found)
    merged = of_codes(few // 2, goals, size)
    assert merged.value_lost >= found.value_lost - 1e-12
    assert merged.shared >= found.shared
    assert 0 <= found.value_lost <= 1 + 1e-12


@pytest.mark.parametrize("representation", [AdHoc(), Direct()])
def test_a_representation_that_tells_all_states_apart_has_none(representation):
    found = aliasing_by_layout(representation, Torus(size=5), layouts(1, 25, 3, 4), GoalReward(), QLearning())
    assert {name: values.tolist() for name, values in found.items()} == dict.fromkeys(Aliasing._fields, [0.0] * 4)
