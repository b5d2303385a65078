"""Observations at positions computed by hand."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from rl_design_space.design import AdHoc, Direct, Direction, Distance, Torus, Walled, cell_count, encode
from rl_design_space.errors import ConfigError

HERE, RIGHT, LEFT, ABOVE, BELOW = range(5)
WORLD = Torus(size=10)


def cell(x: int, y: int) -> int:
    return 10 * y + x


def code(representation, agent: tuple[int, int], goals: list[tuple[int, int]], counter: int = 0, world=WORLD) -> int:
    """Return the observation for an agent and goals at these coordinates of a grid ten cells wide."""
    codes = representation.observation(world, np.array([cell(*goal) for goal in goals]))
    return int(codes[counter, cell(*agent)])


@pytest.mark.parametrize(
    ("agent", "goal", "distance"),
    [
        ((5, 5), (5, 5), 0),
        ((5, 5), (7, 7), 4),
        ((5, 5), (8, 3), 5),
        # The shorter way leads over the border.
        ((0, 0), (9, 9), 2),
        ((0, 0), (5, 5), 10),
        ((1, 8), (8, 1), 6),
    ],
)
def test_distance_is_manhattan_on_the_torus(agent, goal, distance):
    assert code(Distance(), agent, [goal]) == distance
    assert code(Distance(), goal, [agent]) == distance


def test_distance_with_walls_does_not_cross_the_border():
    assert code(Distance(), (0, 0), [(9, 9)], world=Walled(size=10)) == 18


@pytest.mark.parametrize(("counter", "expected"), [(0, 3 + 3 * 11 + 2 * 121), (2, 3 + 3 * 11 + 2 * 121 + 2 * 1331)])
def test_distances_to_all_goals_and_the_counter_make_one_code(counter, expected):
    goals = [(6, 7), (2, 5), (5, 3)]
    assert code(Distance(goals="all"), (5, 5), goals, counter) == expected


@pytest.mark.parametrize("rule", ["dominant_axis", "horizontal_first"])
@pytest.mark.parametrize("goal", [(7, 7), (8, 3)])
def test_both_rules_fit_the_example_of_the_paper(rule, goal):
    assert code(Direction(rule=rule), (5, 5), [goal]) == RIGHT


@pytest.mark.parametrize(
    ("goal", "dominant", "horizontal_first"),
    [
        ((5, 5), HERE, HERE),
        ((6, 5), RIGHT, RIGHT),
        ((4, 5), LEFT, LEFT),
        ((5, 4), ABOVE, ABOVE),
        ((5, 6), BELOW, BELOW),
        ((6, 8), BELOW, RIGHT),
        ((4, 1), ABOVE, LEFT),
        ((3, 7), LEFT, LEFT),
        ((6, 4), RIGHT, RIGHT),
        # Half-way round, both ways are equally long: right and below.
        ((0, 5), RIGHT, RIGHT),
        ((5, 0), BELOW, BELOW),
        # Over the border.
        ((5, 9), BELOW, BELOW),
        ((9, 9), RIGHT, RIGHT),
    ],
)
def test_direction(goal, dominant, horizontal_first):
    assert code(Direction(), (5, 5), [goal]) == dominant
    assert code(Direction(rule="horizontal_first"), (5, 5), [goal]) == horizontal_first


def test_direction_crosses_the_border_when_that_is_shorter():
    assert code(Direction(), (0, 0), [(9, 0)]) == LEFT
    assert code(Direction(), (0, 0), [(0, 9)]) == ABOVE
    assert code(Direction(), (0, 0), [(9, 0)], world=Walled(size=10)) == RIGHT


def test_directions_to_all_goals_and_the_counter_make_one_code():
    goals = [(8, 5), (5, 8), (2, 5)]
    assert code(Direction(goals="all"), (5, 5), goals, counter=1) == RIGHT + 5 * BELOW + 25 * LEFT + 125


def test_a_direction_has_the_same_code_in_a_world_of_another_size():
    goal = np.array([3])
    small, large = (Direction().observation(Torus(size=size), goal) for size in (10, 30))
    assert set(np.unique(small)) == set(np.unique(large))
    assert small[0, 0] == large[0, 0] == RIGHT


@pytest.mark.parametrize(
    ("counter", "observed"), [(0, (RIGHT, BELOW, LEFT)), (1, (HERE, BELOW, LEFT)), (2, (HERE, HERE, LEFT))]
)
def test_goals_already_reached_are_masked(counter, observed):
    goals = [(8, 5), (5, 8), (2, 5)]
    expected = 125 * counter + sum(digit * 5**goal for goal, digit in enumerate(observed))
    assert code(Direction(), (5, 5), goals, counter) == expected


def test_masked_distances_do_not_depend_on_the_goals_reached():
    masked, every = Distance(), Distance(goals="all")
    near, far = [(6, 5), (2, 2)], [(9, 9), (2, 2)]
    assert code(masked, (5, 5), near, counter=1) == code(masked, (5, 5), far, counter=1)
    assert code(every, (5, 5), near, counter=1) != code(every, (5, 5), far, counter=1)
    assert code(masked, (5, 5), near, counter=0) != code(masked, (5, 5), far, counter=0)


def test_ad_hoc_is_the_cell_and_the_counter_for_all_goals():
    assert code(AdHoc(), (3, 3), [(6, 7), (2, 5)]) == 33
    assert code(AdHoc(), (3, 3), [(1, 1), (9, 9)], counter=1) == 133


def test_direct_has_a_distinct_code_for_every_state():
    world = Torus(size=(3, 2))
    layouts = np.array([(first, second) for first, second in product(range(6), repeat=2) if first != second])
    codes = Direct().observation(world, layouts)
    assert np.unique(codes).size == codes.size == len(layouts) * 2 * 6


@pytest.mark.parametrize("n_goals", [9, 20, 99])
def test_direct_with_more_states_than_64_bits_stays_distinct_within_a_layout(n_goals):
    layouts = np.stack([np.arange(n_goals), np.arange(n_goals)[::-1]]).astype(np.int32)
    codes = Direct().observation(WORLD, layouts)
    assert Direct().spanned_size(WORLD, n_goals) > 2**63
    assert codes.dtype == np.int64
    assert codes.min() >= 0
    assert np.unique(codes).size == 2 * n_goals * cell_count(WORLD)


def test_the_digest_of_a_layout_does_not_depend_on_batch_or_integer_type():
    layout = np.arange(20)
    many = Direct().observation(WORLD, np.stack([layout[::-1], layout, layout + 1]))
    np.testing.assert_array_equal(Direct().observation(WORLD, layout.astype(np.int32)), many[1])


@pytest.mark.parametrize(("representation", "most"), [(Direction(), 25), (Distance(), 17)], ids=str)
def test_goals_whose_codes_do_not_fit_64_bits_are_refused(representation, most):
    assert representation.observation(WORLD, np.arange(most)).min() >= 0
    with pytest.raises(ValueError, match=f"task.goals={most + 1}: .* use fewer goals"):
        representation.observation(WORLD, np.arange(most + 1))


def test_the_largest_code_that_fits_is_exact():
    # 5^25 · 25 < 2^63: a detour through floating point would lose the last digits.
    digits = np.full((25, 1), 4)
    assert encode(digits, 5)[-1, 0] == 5**25 * 25 - 1


def test_encode_has_one_digit_per_goal():
    digits = np.array([[1, 2], [3, 0]])
    assert encode(digits, 4).tolist() == [[1 + 12, 2], [16 + 1 + 12, 16 + 2]]
    assert encode(digits, 4, "remaining").tolist() == [[1 + 12, 2], [16 + 12, 16]]


@pytest.mark.parametrize(
    ("digits", "base", "message"),
    [
        ([[0, 3]], 3, r"encode\(digits, base=3\): digits should be from 0 to 2, but are from 0 to 3; different obser"),
        ([[-1, 2]], 3, "digits should be from 0 to 2, but are from -1 to 2"),
        ([[0.0, 1.0]], 3, "should be whole numbers, not float64 and int"),
        ([[0, 1]], 3.0, "should be whole numbers, not int64 and float"),
    ],
    ids=str,
)
def test_encode_refuses_what_would_share_a_code(digits: list, base: int, message: str):
    with pytest.raises(ConfigError, match=message):
        encode(np.array(digits), base)


@pytest.mark.parametrize("dtype", [np.int8, np.uint8, np.int32, np.uint16, np.int64])
def test_encode_takes_digits_of_any_size(dtype: type):
    last = np.iinfo(dtype).max if np.dtype(dtype).itemsize == 1 else 300
    digits = np.array([[0, last], [last, 1]], dtype=dtype)
    assert encode(digits, int(last) + 1).dtype == np.int64
    with pytest.raises(ConfigError):
        encode(digits, int(last))


def test_a_base_of_numpy_does_not_overflow():
    with pytest.raises(ValueError, match="more than 64 bits"):
        encode(np.zeros((4, 1), dtype=np.int64), np.int64(2**16))
