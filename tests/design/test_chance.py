"""Worlds with chance: their outcomes."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.design import Slip, Wind, open_cells, undisturbed
from rl_design_space.learning.optimum import shortest_tours

RIGHT, LEFT, ABOVE, BELOW = range(4)
#: Of 3×3 cells, the cells around the middle one, which has number 4.
AROUND = {RIGHT: 5, LEFT: 3, ABOVE: 1, BELOW: 7}


@pytest.mark.parametrize(
    ("astray", "step", "others"),
    [
        ("sides", RIGHT, [ABOVE, BELOW]),
        ("sides", BELOW, [RIGHT, LEFT]),
        ("left", RIGHT, [ABOVE]),
        ("left", LEFT, [BELOW]),
        ("left", ABOVE, [LEFT]),
        ("right", BELOW, [LEFT]),
        ("right", ABOVE, [RIGHT]),
        ("others", LEFT, [BELOW, ABOVE, RIGHT]),
    ],
)
def test_a_slip_leads_to_where_its_option_says(astray: str, step: int, others: list[int]):
    cells, probabilities = Slip(size=3, p=0.3, astray=astray).outcomes()
    assert cells[step, 4].tolist() == [AROUND[step], *(AROUND[other] for other in others)]
    assert probabilities[step, 4] == pytest.approx([0.7, *[0.3 / len(others)] * len(others)])


def test_a_slip_may_leave_the_agent_where_it_is():
    assert Slip(size=3, p=0.3, astray="stays").outcomes().cells[RIGHT].tolist()[4] == [5, 4]


def test_a_slip_against_a_wall_has_no_effect():
    assert Slip(size=3, border="walled").outcomes().cells[RIGHT, 0].tolist() == [1, 0, 3]


def test_the_windy_world_of_the_textbook_has_its_optimum():
    """Sutton and Barto, 2nd edition, Example 6.5: 15 steps from (0, 3) to (7, 3)."""
    world = Wind(size=(10, 7), border="walled", gusts=0.0)
    start, goal = 3 * 10, 3 * 10 + 7
    assert world.next_cell()[LEFT, goal + 1] == goal - 10, "one cell right of the goal, left leads just above it"
    assert shortest_tours(world.next_cell(), np.array([[start, goal]], dtype=np.int32)).tolist() == [15]


def test_gusts_change_the_wind_by_one_where_there_is_any():
    cells, probabilities = Wind(size=5, strengths=(0, 1, -2, 0, 0), gusts=0.25).outcomes()
    column = cells[LEFT, 10:15].tolist()  # from the middle row, y = 2
    assert (np.array(column[1]) // 5).tolist() == [1, 0, 2]
    assert (np.array(column[2]) // 5).tolist() == [4, 0, 3], "down, round the border"
    assert (np.array(column[0]) // 5).tolist() == [2, 2, 2]
    assert probabilities[LEFT, 0].tolist() == [0.5, 0.25, 0.25]


def test_starts_and_goals_lie_where_the_wind_lets_all_be_reached():
    world = Wind(size=(10, 7), border="walled", gusts=0.0)
    assert 6 * 10 + 7 not in open_cells(world), "nothing leads down to the lower end of the strongest wind"
    assert 3 * 10 in open_cells(world)


def test_pictures_show_the_walls_of_the_undisturbed_world():
    assert undisturbed(Wind(border="walled")).next_cell()[ABOVE, 0] == 0
    assert undisturbed(Slip(size=4)) == undisturbed(Slip(size=4, p=0.5))
