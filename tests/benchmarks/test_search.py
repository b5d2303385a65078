"""Ways to find the best of many points, on made-up numbers."""

from __future__ import annotations

import numpy as np

from benchmarks.search_methods import halved, raced
from benchmarks.search_studies import Sweep
from rl_design_space.analysis.best import best_means


def test_a_race_and_successive_halving_find_the_best_with_fewer_steps():
    rng = np.random.default_rng(0)
    values = 10 + rng.normal(size=(60, 30)) + np.linspace(0, 6, 30)
    full = best_means(values)
    race = raced(values)
    assert race.inside.tolist() == full.inside.tolist()
    assert race.winner == full.leader
    assert race.steps < values.sum() / 1.5
    other = halved(values, race.steps)
    assert other.steps <= race.steps
    assert other.winner in np.flatnonzero(full.inside)


def test_points_are_numbered_as_their_sweep_lists_them():
    sweep = Sweep("mine", np.zeros((1, 6)), {"a": (1, 2), "b": ("x", "y", "z")})
    assert [sweep.number({"a": a, "b": b}) for a in (1, 2) for b in "xyz"] == [0, 1, 2, 3, 4, 5]
