"""Measures at the best of several schedules: values, and the bias and coverage of choosing and judging together."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis import at_best as module
from rl_design_space.analysis.at_best import at_best
from rl_design_space.learning import LearningCurves
from rl_design_space.learning.measures import measure

PERIODS, OPTIMUM = 40, 10
TOTAL = measure("total_steps")


def recorded(steps, exploration: float = 1.0) -> LearningCurves:
    """Return a result of (periods, trials) or (periods,) steps."""
    steps = np.asarray(steps, dtype=np.int32).reshape(len(steps), -1)
    periods, trials = steps.shape
    return LearningCurves(
        steps=steps,
        success=np.ones(steps.shape, dtype=np.bool_),
        optimum=np.full(periods, OPTIMUM, dtype=np.int32),
        rows=np.zeros((periods, 2), dtype=np.int32),
        epsilon=np.full(trials, exploration / trials),
    )


def level(steps: int, exploration: float = 1.0, trials: int = 20) -> LearningCurves:
    """Return a result that needs ten times the optimum in the first trial, and so many steps from then on."""
    curve = np.full((PERIODS, trials), steps)
    curve[:, 0] = 10 * OPTIMUM
    return recorded(curve, exploration)


def test_all_measures_are_those_of_the_best_schedule():
    schedules = {"slow": level(30, 9.0), "fast": level(11, 3.0), "slower": level(40, 5.0)}
    measures = {
        name: measure(name) for name in ("final_over_optimum", "gap_closed=0.9", "total_steps,statistic=median")
    }
    found = at_best(schedules, TOTAL, measures)
    assert found.best == "fast"
    assert found.exploration == pytest.approx((3, 3, 3))
    assert found.measured["final_over_optimum"] == pytest.approx((1.1, 1.1, 1.1, False))
    assert found.measured["gap_closed=0.9"] == (1, 1, 1, False)
    assert found.measured["total_steps,statistic=median"].value == 10 * OPTIMUM + 19 * 11


def test_the_best_is_that_of_the_measure_it_is_chosen_by():
    early, late = np.full((PERIODS, 20), 20), np.full((PERIODS, 20), 11)
    late[:, :5] = 200
    schedules = {"early": recorded(early), "late": recorded(late)}
    found = {by: at_best(schedules, measure(by), {}).best for by in ("total_steps", "steps_after=10", "near_share=1.1")}
    assert found == {"total_steps": "early", "steps_after=10": "late", "near_share=1.1": "late"}


def test_never_has_no_upper_end():
    found = at_best({"only": level(30)}, TOTAL, {"never": measure("trials_to=1.1")})
    assert found.measured["never"] == (20, 20, np.inf, True)


def test_a_share_of_no_period_has_an_interval():
    found = at_best({"only": level(30)}, TOTAL, {"near": measure("near_share=1.1")}).measured["near"]
    assert found[:2] == pytest.approx((0, 0))
    # z² / (n + z²)
    assert found.high == pytest.approx(1.96**2 / (PERIODS + 1.96**2), abs=1e-3)


def test_one_period_is_enough():
    found = at_best({"a": recorded([50]), "b": recorded([40])}, TOTAL, {"total": TOTAL})
    assert found.best == "b"
    assert found.measured["total"].value == 40
    assert np.isnan(found.measured["total"].low)


def test_a_period_judges_no_schedule_that_it_has_helped_to_choose():
    # Every schedule is lucky in one period of its own, and no better elsewhere: there is nothing to find.
    lucky = {str(each): recorded(np.where(np.arange(PERIODS) == each, 1, 100)) for each in range(PERIODS)}
    assert at_best(lucky, TOTAL, {"total": TOTAL}).measured["total"].value == 100
    flattered = min(result.total_steps.mean() for result in lucky.values())
    assert flattered < 100


def test_the_value_is_not_flattered_and_its_interval_covers(monkeypatch: pytest.MonkeyPatch):
    """Equal schedules with heavy tails are the worst case: whatever is chosen has the same true mean."""
    monkeypatch.setattr(module, "_RESAMPLES", 200)
    rng = np.random.default_rng(5)
    true = 1000 * np.exp(0.7**2 / 2)
    ours, halves, flattered, covered = [], [], [], []
    for _ in range(120):
        drawn = rng.lognormal(np.log(1000), 0.7, size=(5, PERIODS))
        schedules = {str(place): recorded(steps) for place, steps in enumerate(drawn)}
        found = at_best(schedules, TOTAL, {"total": TOTAL}).measured["total"]
        ours.append(found.value / true)
        covered.append(found.low <= true <= found.high)
        flattered.append(drawn.mean(axis=1).min() / true)
        halves.append(drawn[drawn[:, 0::2].mean(axis=1).argmin(), 1::2].mean() / true)
    error = np.std(ours) / np.sqrt(len(ours))
    assert abs(np.mean(ours) - 1) < 3 * error
    assert np.mean(flattered) < 1 - 5 * error
    assert np.std(ours) < 0.8 * np.std(halves)
    assert np.mean(covered) >= 0.93
