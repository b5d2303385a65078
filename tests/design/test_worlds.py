"""Worlds: transitions, and offsets of goals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl_design_space.design import MOVES, Torus, Walled, World, cell_count

RIGHT, LEFT, ABOVE, BELOW = range(4)
worlds = st.builds(
    lambda option, dx, dy: option(size=(dx, dy)),
    st.sampled_from([Torus, Walled]),
    st.integers(2, 9),
    st.integers(2, 9),
)


def test_transitions_on_a_torus_of_three_by_two_cells():
    # 0 1 2
    # 3 4 5
    assert Torus(size=(3, 2)).next_cell().tolist() == [
        [1, 2, 0, 4, 5, 3],
        [2, 0, 1, 5, 3, 4],
        [3, 4, 5, 0, 1, 2],
        [3, 4, 5, 0, 1, 2],
    ]


def test_transitions_between_walls_of_three_by_two_cells():
    assert Walled(size=(3, 2)).next_cell().tolist() == [
        [1, 2, 2, 4, 5, 5],
        [0, 0, 1, 3, 3, 4],
        [0, 1, 2, 0, 1, 2],
        [3, 4, 5, 3, 4, 5],
    ]


@given(world=worlds)
def test_opposite_steps_cancel_unless_there_is_a_wall(world: World):
    table = world.next_cell()
    cells = np.arange(cell_count(world))
    for there, back in ((RIGHT, LEFT), (LEFT, RIGHT), (ABOVE, BELOW), (BELOW, ABOVE)):
        moved = table[there] != cells
        returned = table[back, table[there]]
        np.testing.assert_array_equal(returned[moved], cells[moved])
        assert moved.all() or isinstance(world, Walled)


@given(world=worlds, data=st.data())
def test_following_the_offset_leads_to_the_goal(world: World, data: st.DataObject):
    cells = st.integers(0, cell_count(world) - 1)
    cell, goal = data.draw(cells), data.draw(cells)
    x, y = (int(way[0, cell]) for way in world.offset(np.array([goal])))
    table = world.next_cell()
    for move, times in ((RIGHT, x), (LEFT, -x), (BELOW, y), (ABOVE, -y)):
        for _ in range(times):
            cell = table[move, cell]
    assert cell == goal


@given(world=worlds)
def test_reach_is_the_largest_offset(world: World):
    x, y = world.offset(np.arange(cell_count(world)))
    assert (np.abs(x).max(), np.abs(y).max()) == world.reach


@pytest.mark.parametrize(("side", "offsets"), [(4, [0, -1, 2, 1]), (5, [0, -1, -2, 2, 1]), (2, [0, 1])])
def test_half_way_round_a_torus_is_to_the_right_and_below(side: int, offsets: list[int]):
    world = Torus(size=side)
    x, y = world.offset(np.array([0]))
    assert x[0, :side].tolist() == offsets
    assert y[0, ::side].tolist() == offsets


def test_offsets_between_walls_never_cross_the_border():
    x, y = Walled(size=(4, 3)).offset(np.array([5]))
    assert x[0].tolist() == [1, 0, -1, -2] * 3
    assert y[0].tolist() == [1] * 4 + [0] * 4 + [-1] * 4


def test_moves_are_in_the_order_of_every_table():
    world = Walled(size=3)
    x, y = world.offset(np.array([4]))
    for move, (step_x, step_y) in enumerate(MOVES):
        neighbour = world.next_cell()[move, 4]
        assert (x[0, neighbour], y[0, neighbour]) == (-step_x, -step_y)


@pytest.mark.parametrize("option", [Torus, Walled])
def test_both_spellings_of_a_square_are_equal(option):
    written = [option(size=4), option(size=(4, 4)), option(size=[4, 4])]
    assert len(set(written)) == 1
    assert {world.size for world in written} == {4}
    assert {world.shape for world in written} == {(4, 4)}


def test_shape_is_along_x_then_along_y():
    world = Torus(size=(4, 3))
    assert world.shape == (4, 3)
    assert world.reach == (2, 1)
    assert cell_count(world) == 12
    assert world != Torus(size=(3, 4))
    assert world != Walled(size=(4, 3))
