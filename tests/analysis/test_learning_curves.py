"""Learning curves with their bands, and the random walk as their baseline."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.learning_curves import curve_frame, curve_summary, random_walk_steps
from rl_design_space.design import Torus, Walled
from tests.analysis.made_up import TRIALS, MadeUp


def test_a_curve_has_a_row_for_each_trial():
    made = MadeUp(until=5, noise=0.2, failed=0.25)
    frame = curve_frame(made)
    assert frame["trial"].tolist() == list(range(TRIALS))
    assert frame["mean"].tolist() == pytest.approx(made.steps.mean(axis=0).tolist())
    assert frame["median"].tolist() == np.median(made.steps, axis=0).tolist()
    assert frame["failed"].tolist() == pytest.approx([0.25] * TRIALS)
    assert (frame["ci_low"] <= frame["mean"]).all()
    assert (frame["mean"] <= frame["ci_high"]).all()
    assert (frame["q10"] <= frame["q90"]).all()


def test_a_band_is_narrower_with_more_periods():
    widths = []
    for periods in (20, 500):
        frame = curve_frame(MadeUp(periods=periods, noise=0.3))
        widths.append((frame["ci_high"] - frame["ci_low"]).mean())
    assert widths[1] < widths[0] / 3


def test_equal_periods_have_a_band_without_width():
    frame = curve_frame(MadeUp(noise=0.0))
    assert np.allclose(frame["ci_low"], frame["ci_high"])


def test_the_summary_by_hand():
    found = curve_summary(MadeUp(last=12.0, first=200.0, until=5, noise=0.0, failed=0.5, exploration=7.0))
    assert found["total_steps"] == 5 * 200 + 15 * 12
    assert found["trials_to_final"] == 5
    assert found["final_over_optimum"] == pytest.approx(1.2)
    assert found["failed"] == pytest.approx(0.5)
    assert found["exploration"] == pytest.approx(7)


def test_a_random_walk_in_a_corridor_by_hand():
    # h0 = 1 + 3/4 h0 + 1/4 h1 and h1 = 1 + 1/4 h0 + 1/2 h1 give h0 = 12, h1 = 8.
    class Corridor(Walled):
        def next_cell(self):
            return np.array([[1, 2, 2], [0, 0, 1], [0, 1, 2], [0, 1, 2]], dtype=np.int32)

    world = Corridor(size=2)
    assert random_walk_steps(world, np.array([[0, 2]], dtype=np.int32)) == pytest.approx(12)
    assert random_walk_steps(world, np.array([[1, 2]], dtype=np.int32)) == pytest.approx(8)
    assert random_walk_steps(world, np.array([[0, 2], [1, 2]], dtype=np.int32)) == pytest.approx(10)
    assert random_walk_steps(world, np.array([[0, 2, 0]], dtype=np.int32)) == pytest.approx(24)


def test_a_random_walk_on_a_torus_agrees_with_walks():
    rng, world = np.random.default_rng(0), Torus(size=4)
    next_cell = world.next_cell()
    taken = []
    for _ in range(3000):
        cell, steps = 0, 0
        while cell != 5:
            cell, steps = next_cell[rng.integers(4), cell], steps + 1
        taken.append(steps)
    expected = random_walk_steps(world, np.array([[0, 5]], dtype=np.int32))
    assert np.mean(taken) == pytest.approx(expected, abs=5 * np.std(taken) / np.sqrt(len(taken)))


@pytest.mark.parametrize("world", [Torus(size=5), Walled(size=5), Torus(size=4)])
def test_random_walks_solve_the_equations_of_each_goal(world: Torus | Walled):
    next_cell = world.next_cell()
    cells = next_cell.shape[1]
    walk = sum(np.eye(cells)[row] for row in next_cell) / len(next_cell)
    for goal in (0, 7, cells - 1):
        others = np.flatnonzero(np.arange(cells) != goal)
        by_hand = np.linalg.solve((np.eye(cells) - walk)[np.ix_(others, others)], np.ones(cells - 1))
        found = [random_walk_steps(world, np.array([[start, goal]], dtype=np.int32)) for start in others]
        assert found == pytest.approx(by_hand.tolist())


def test_a_band_covers_the_mean_that_periods_are_drawn_from():
    drawn = np.random.default_rng(1).exponential(50, size=(200, 300)).round()  # 300 trials, all alike

    class Drawn(MadeUp):
        steps = property(lambda self: drawn)
        success = property(lambda self: np.ones(drawn.shape, dtype=bool))

    frame = curve_frame(Drawn())
    covered = ((frame["ci_low"] <= 50) & (frame["ci_high"] >= 50)).mean()
    assert 0.9 < covered < 0.99
