"""Properties of representations, on layouts that can be checked by eye."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from rl_design_space.analysis.properties import optimal_moves, properties
from rl_design_space.design import AdHoc, Direct, Direction, Distance, Torus, cell_count
from rl_design_space.learning.streams import layouts

WORLD, LARGER = Torus(size=5), Torus(size=9)


@dataclass(frozen=True)
class Blind:
    """A representation with one observation for all states."""

    def observation(self, world, goals):
        return np.zeros((*goals.shape, cell_count(world)), dtype=np.int64)


def found(representation, goals: int = 1, world=WORLD):
    here, there = (layouts(3, cell_count(each), goals, 20) for each in (world, LARGER))
    return properties(representation, world, LARGER, here, there)


def test_optimal_moves_by_hand():
    # A goal in the middle of 3×3: right, left, above, below as rows of the table.
    best = optimal_moves(Torus(size=3), np.array([4], dtype=np.int32))[:, 0]
    right, left, above, below = best
    assert np.flatnonzero(right).tolist() == [0, 3, 4, 6]
    assert np.flatnonzero(left).tolist() == [2, 4, 5, 8]
    assert np.flatnonzero(above).tolist() == [4, 6, 7, 8]
    assert np.flatnonzero(below).tolist() == [0, 1, 2, 4]


def test_the_own_cell_as_observation_aliases_no_states():
    ad_hoc = found(AdHoc())
    assert (ad_hoc.states_each, ad_hoc.aliased) == (1, 0)
    # With other goals its moves are no better than any: about half of them are optimal.
    assert 0.3 < ad_hoc.other_goals < 0.75


def test_a_single_observation_aliases_all_states():
    blind = found(Blind())
    assert (blind.states_each, blind.aliased) == (25, 1)


def test_the_direction_of_a_single_goal_carries_over_to_any_goal_and_grid():
    direction = found(Direction())
    assert direction.aliased == 0
    assert direction.other_goals == 1
    assert direction.larger_grid == 1


def test_distances_are_the_same_on_opposite_sides_of_a_goal():
    distance = found(Distance())
    assert distance.aliased > 0.5
    assert distance.states_each > 1


def test_a_full_state_does_not_occur_with_other_goals():
    direct = found(Direct(), goals=2)
    assert direct.aliased == 0
    assert direct.other_goals == 0
    assert direct.larger_grid == pytest.approx(0, abs=0.05)
