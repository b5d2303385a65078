"""Representations with fewer attributes: the due goal alone, and attributes that are left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.design import (
    AdHoc,
    Aggregated,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    Task,
    Torus,
    Without,
    encode,
)
from rl_design_space.learning import simulate

WORLD = Torus(size=6)
POINT = DesignPoint(task=Task(goals=2, trials=8, periods=20), world=WORLD)


def same_partition(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two arrays of codes tell the same states apart."""
    pairs = np.unique(np.stack([one.ravel(), other.ravel()]), axis=1).shape[1]
    return pairs == len(np.unique(one)) == len(np.unique(other))


def test_only_the_digit_of_the_due_goal_is_encoded():
    digits = np.array([[1, 2], [3, 0], [2, 2]])
    assert encode(digits, 4, "due").tolist() == [[1, 2], [12 + 64, 64], [32 + 128, 32 + 128]]


@pytest.mark.parametrize("kind", [Distance, Direction])
def test_the_due_goal_alone_is_what_the_last_goal_is_of_the_remaining_ones(kind):
    goals = np.array([8, 20, 33])
    due, remaining = (kind(goals=each).observation(WORLD, goals) for each in ("due", "remaining"))
    np.testing.assert_array_equal(due[2], remaining[2])
    for counter in range(3):
        alone = kind().observation(WORLD, goals[counter : counter + 1])[0]
        assert same_partition(due[counter], alone)


def test_actions_see_no_other_goal_than_the_due_one():
    goals = np.array([8, 20])
    sight = Direction(goals="due").sight(WORLD, 2, Direction(goals="due").observation(WORLD, goals))
    every = Direction(goals="all").sight(WORLD, 2, Direction(goals="all").observation(WORLD, goals))
    for axis in ("x", "y"):
        seen, all_seen = getattr(sight, axis), getattr(every, axis)
        np.testing.assert_array_equal(seen[[0, 1], [0, 1]], all_seen[[0, 1], [0, 1]])
        assert (seen[[1, 0], [0, 1]] == 2).all()


@pytest.mark.parametrize("of", [AdHoc(), Aggregated(), Distance(), Direction(goals="all")], ids=str)
def test_with_nothing_left_out_it_learns_as_the_other_representation(of):
    every, plain = (simulate(replace(POINT, representation=each)) for each in (Without(of=of), of))
    np.testing.assert_array_equal(every.steps, plain.steps)


def test_attributes_that_are_left_out_are_not_told_apart():
    goals = np.array([8, 20])
    without = Without(of=Direction(goals="all"), leave_out=("goal2",)).observation(WORLD, goals)
    first = Direction().observation(WORLD, goals[:1])[0]
    assert all(same_partition(without[counter], first) for counter in range(2))
    assert not set(without[0]) & set(without[1])
    assert (np.diff(Without(of=AdHoc(), leave_out=("counter",)).observation(WORLD, goals), axis=0) == 0).all()
    columns = Without(of=AdHoc(), leave_out=("y",)).observation(WORLD, goals)
    assert len(np.unique(columns)) == 2 * 6


def test_attributes_may_be_left_out_at_one_counter_alone():
    goals = np.array([8, 20])
    of = Direction(goals="all")
    some = Without(of=of, leave_out=("goal2",), counters=(1,)).observation(WORLD, goals)
    plain = of.observation(WORLD, goals)
    assert same_partition(some[0], plain[0])
    assert same_partition(some[1], Direction().observation(WORLD, goals[:1])[0])


@pytest.mark.parametrize(
    ("representation", "message"),
    [
        (Without(leave_out=("goal3",)), "representation.leave_out: goal3: no such attribute; did you mean goal"),
        (Without(of=Direct()), r"representation.of: Direct has no method attributes\(\)"),
        (Without(leave_out=("counter",), counters=(0,)), "an agent without counter cannot know them"),
        (Without(leave_out=("goal1",), counters=(0, 2)), r"representation.counters=\[2\]: with 2 goals the success"),
        (Without(of=Aggregated(block=4)), "representation.block=4: does not divide the 6×6 world"),
    ],
)
def test_what_cannot_be_left_out_is_refused(representation, message):
    with pytest.raises(ValueError, match=message):
        replace(POINT, representation=representation)
