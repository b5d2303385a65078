"""What the agent knows after a trial, and which period and trial a name means."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from rl_design_space.analysis.snapshot import chosen_period, chosen_trial, edges_of, snapshot
from rl_design_space.design import DesignPoint, Direction, Task, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.learning.replay import Replay, Replayer
from rl_design_space.learning.sequential.method import Path

POINT = DesignPoint(representation=Direction(), world=Torus(size=6), task=Task(goals=2, trials=12, periods=3))


@pytest.fixture(scope="module")
def inside() -> Replay:
    return Replayer(POINT)(1)


def test_a_snapshot_is_of_the_matrix_after_its_trial(inside: Replay):
    seen = snapshot(inside, 4)
    q = inside.history[4][inside.row]
    np.testing.assert_array_equal(seen.values, q.max(axis=-1))
    np.testing.assert_array_equal(seen.greedy, q == q.max(axis=-1, keepdims=True))
    np.testing.assert_array_equal(seen.learned, (q != 0).any(axis=-1))
    assert (seen.steps, seen.success) == (inside.steps[4], inside.success[4])


def test_visits_grow_with_the_trials(inside: Replay):
    counts = [snapshot(inside, trial).visits for trial in range(12)]
    assert all((after >= before).all() for before, after in pairwise(counts))
    np.testing.assert_array_equal(counts[-1], inside.visits)


@pytest.mark.parametrize(("name", "expected"), [("worst", 1), ("median", 0), ("best", 2), (3, 3)])
def test_periods_are_found_by_their_steps(name: int | str, expected: int):
    assert chosen_period(name, np.array([5.0, 9, 1, 9])) == expected


@pytest.mark.parametrize(("name", "expected"), [("first", 0), ("last", 3), ("worst", 1), (np.int64(2), 2)])
def test_trials_are_found_by_place_and_steps(name: int | str, expected: int):
    assert chosen_trial(name, np.array([5, 9, 1, 9], dtype=np.int32)) == expected


@pytest.mark.parametrize("wrong", ["worse", 4, -1, True, 1.0])
def test_other_names_and_numbers_are_refused(wrong):
    with pytest.raises(ConfigError, match=r"period=.*should be a number from 0 to 3, or worst, median or best"):
        chosen_period(wrong, np.zeros(4))
    with pytest.raises(ConfigError, match=r"trial=.*or worst, median, best, first or last"):
        chosen_trial(wrong, np.zeros(4, dtype=np.int32))


def test_steps_of_a_path_are_counted_by_counter():
    cells, counters = np.array([0, 1, 0, 1, 2]), np.array([0, 0, 0, 1, 1])
    path = Path(cells, counters, np.zeros(4), np.zeros(4, dtype=bool))
    edges, counts = edges_of(path, 0)
    assert edges.tolist() == [[0, 1], [1, 0]]
    assert counts.tolist() == [2, 1]
    assert edges_of(path, 1)[0].tolist() == [[1, 2]]
