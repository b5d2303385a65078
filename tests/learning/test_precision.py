"""Enough periods: the rule, its interval, and that a result follows from the point alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from docs.enough_periods import cell, one_in_twenty, skewed, stop
from rl_design_space.design import DesignPoint, Linear, Task, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.precision import Precision, anytime_half_width

RULE = Precision(0.05, "total_steps", 100, 2000)
POINT = DesignPoint(
    world=Torus(size=5), exploration=Linear(k=0.1), task=Task(periods=60, trials=10, precision=0.05, goals=2)
)


def test_looks_grow_by_a_quarter_up_to_the_limit():
    looks = list(RULE.looks())
    assert looks[:4] == [100, 125, 157, 196]
    assert looks[-1] == 2000
    assert max(np.array(looks[1:]) / looks[:-1]) < 1.27
    assert list(replace(RULE, at_most=100).looks()) == [100]


@pytest.mark.parametrize(
    ("periods", "reached", "following"),
    [
        (100, 0.05, None),
        (100, 0.051, 125),
        # 400 periods seem to be needed: the last look before 90 % of them.
        (100, 0.1, 306),
        (100, 5.0, 382),
        (100, float("inf"), 382),
        (1941, 0.06, 2000),
        (2000, 0.06, None),
    ],
)
def test_learning_goes_on_until_the_precision_or_the_limit_is_reached(
    periods: int, reached: float, following: int | None
):
    assert RULE.following(periods, reached) == following


def test_the_interval_is_that_of_the_publication():
    # Waudby-Smith et al., theorem 2.2, with numbers by hand: ρ² = 7.94 / 400, n = 100, standard deviation 1.
    values = np.tile([-1.0, 1.0], 50) * np.sqrt(99 / 100)
    tuned = (-2 * np.log(0.05) + np.log(1 - 2 * np.log(0.05))) / 400
    expected = np.sqrt(2 * (100 * tuned + 1) / (100**2 * tuned) * np.log(np.sqrt(100 * tuned + 1) / 0.05))
    assert anytime_half_width(values, 100) == pytest.approx(expected)
    assert 1.6 < expected / (1.96 / 10) < 1.7


@pytest.mark.parametrize("population", [skewed(), one_in_twenty()], ids=["log-normal", "one in twenty"])
def test_the_interval_holds_the_true_mean_when_learning_stops(population):
    # `python -m docs.enough_periods` does the same with more samples, and with periods of Table 4.
    rng = np.random.default_rng(0)
    stops = [stop(population, Precision(0.2, "total_steps", 200, 20_000), rng) for _ in range(200)]
    assert sum(each.held for each in stops) >= 0.95 * len(stops)
    assert len({each.periods for each in stops}) > 3


def test_the_interval_holds_the_true_mean_of_real_periods():
    rng, population = np.random.default_rng(0), cell(replace(POINT, task=POINT.task.with_periods(1)), periods=3000)
    stops = [stop(population, Precision(0.05, "total_steps", 60, 2000), rng) for _ in range(200)]
    assert sum(each.held for each in stops) >= 0.95 * len(stops)
    # All looks together: the interval is wider than that of a number of periods that is fixed.
    assert sum(each.held for each in stops) >= sum(each.fixed_held for each in stops)


def test_the_result_is_that_of_the_number_of_periods_that_was_enough():
    result = simulate(POINT, threads=1)
    periods, rule = len(result.steps), Precision.of_task(POINT.task)
    assert rule is not None
    assert periods > 60
    assert rule.reached(result) <= 0.05 < rule.reached(result.first(60))
    assert result.point == replace(POINT, task=POINT.task.with_periods(periods))
    np.testing.assert_array_equal(result.steps, simulate(result.point).steps)
    # However many were learned before, and by however many threads.
    for known in (1, 75, 2 * periods):
        begun = simulate(replace(POINT, task=POINT.task.with_periods(known)))
        again = simulate(POINT, threads=2, begun=begun)
        np.testing.assert_array_equal(again.steps, result.steps)
        assert again.point == result.point


def test_another_measure_and_the_limit():
    # A rare failure is not known to 5 % by so few periods.
    task = replace(POINT.task, precision_of="failed_trials", max_steps=30, periods_at_most=300)
    assert len(simulate(replace(POINT, task=task)).steps) == 300
    late = replace(POINT, task=replace(POINT.task, precision_of="steps_after=5"))
    assert len(simulate(late).steps) != len(simulate(POINT).steps)


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ("total_step", "task.precision_of=total_step: total_step: no such measure; did you mean total_steps?"),
        ("steps_after=5,statistic=median", "should be the mean of a number of each period, such as total_steps or"),
        ("trials_to_optimum", "task.precision_of=trials_to_optimum: should be the mean of a number of each period"),
        ("mine.late", "task.precision_of=mine.late: should be a measure of this package"),
    ],
)
def test_only_means_of_this_package_can_be_precise(measure: str, message: str):
    with pytest.raises(ConfigError) as raised:
        simulate(replace(POINT, task=replace(POINT.task, precision_of=measure)))
    assert message in str(raised.value)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"periods_at_most": 100}, "task.periods_at_most=100: needs a precision, such as task.precision=0.02"),
        ({"precision_of": "outliers"}, "task.precision_of=outliers: needs a precision"),
        ({"precision": 0.1, "periods_at_most": 499}, "should be at least task.periods=500, with which learning begins"),
        ({"precision": 0.1, "periods": 1}, "task.periods=1: a precision needs at least 2, better hundreds"),
        ({"precision": 2.0}, "Input should be less than 1"),
        ({"precision": 0.0}, "Input should be greater than 0"),
    ],
)
def test_fields_that_contradict_each_other_are_refused(values: dict[str, object], message: str):
    with pytest.raises(ValidationError) as raised:
        Task(**values)
    assert message in str(raised.value)
