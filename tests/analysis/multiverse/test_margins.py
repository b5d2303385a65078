"""Margins: inside and outside of ranges, censored numbers, and combinations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rl_design_space.analysis.bounds import Bounds, known
from rl_design_space.analysis.multiverse.margins import MOST, Margin, interval, smallest

INF = math.inf


def margin(numbers: list[float], low: float, high: float) -> Margin:
    return Margin.of(known(np.array(numbers, float)), low, high)


def outcome(of: Margin) -> bool | None:
    """Return whether a number is inside; None if that cannot be told."""
    assert not (of.holds & of.fails).any()
    return True if of.holds else False if of.fails else None


@pytest.mark.parametrize(
    ("value", "low", "high", "factor"),
    [(2.0, 1.0, INF, 2), (0.5, 1.0, INF, 0.5), (1.0, -INF, 1.05, 1.05), (3, 1, 4, 4 / 3), (8, 1, 4, 0.5)],
)
def test_a_margin_is_the_factor_from_the_nearest_limit(value: float, low: float, high: float, factor: float):
    assert margin([value], low, high).value == pytest.approx(math.log(factor))


@pytest.mark.parametrize(("value", "low", "margin_"), [(0.1, 0.0, MOST), (-0.1, 0.0, -MOST), (-3, 5, -MOST)])
def test_a_limit_of_0_and_a_wrong_sign_are_as_far_as_can_be(value: float, low: float, margin_: float):
    assert margin([value], low, INF).value == margin_


def test_certainty_counts_the_resamples_that_come_out_alike():
    assert margin([2, 2, 2, 2, 0.5], 1, INF).certainty == 0.75
    assert margin([0.5, 0.4, 0.3, 2], 1, INF).certainty == pytest.approx(2 / 3)


def test_what_follows_from_a_censored_number_is_told_and_the_rest_is_not():
    never = Bounds(np.array([100.0]), np.array([INF]))
    twenty = known(np.array([20.0]))
    assert outcome(Margin.of(never.over(twenty), 1.5, INF)) is True
    assert outcome(Margin.of(never.over(twenty), 6, INF)) is None
    assert outcome(Margin.of(twenty.over(never), -INF, 0.5)) is None  # it is never divided by
    assert outcome(Margin.of(twenty.minus(never), -INF, 0)) is True
    assert outcome(Margin.of(never, -INF, 45)) is False
    assert outcome(Margin.of(never.over(never), 0.8, 1.25)) is None


def test_what_is_not_defined_is_not_told():
    assert outcome(margin([math.nan, 1], 0.5, INF)) is None


def test_all_and_any():
    inside, outside = margin([2], 1, INF), margin([0.5], 1, INF)
    assert outcome(inside & outside) is False
    assert outcome(inside | outside) is True
    assert (inside & outside).value == outside.value


def test_the_smallest_of_numbers_is_bounded_by_the_known_one():
    found = smallest([Bounds(np.array([100.0]), np.array([INF])), known(np.array([30.0]))])
    assert (found.low[0], found.high[0]) == (30, 30)


def test_an_interval_leaves_the_measured_value_aside():
    assert interval(known(np.array([[50.0, *range(1, 101)]] * 2))) == (pytest.approx([3, 3]), pytest.approx([98, 98]))
    assert all(map(math.isnan, interval(known(np.array([1.0])))))


def test_several_readings_at_once_are_those_one_by_one():
    numbers = np.random.default_rng(1).lognormal(size=(5, 11))
    numbers[3, 4] = math.nan
    together = Margin.of(known(numbers), 0.8, 1.25)
    for row, alone in enumerate(numbers):
        one = Margin.of(known(alone), 0.8, 1.25)
        assert (together.holds[row], together.fails[row], together.value[row]) == (one.holds, one.fails, one.value)
        np.testing.assert_equal(together.certainty[row], one.certainty)
        np.testing.assert_equal([end[row] for end in interval(known(numbers))], interval(known(alone)))
