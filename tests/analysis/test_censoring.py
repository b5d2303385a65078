"""Numbers of which some are bounds."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.censoring import Bounded, Censored
from rl_design_space.learning.measures import measure
from tests.analysis.made_up import TRIALS, MadeUp

NOTHING = np.zeros(4, bool)


def upto(never: float, *values: float) -> Censored:
    numbers = np.array(values)
    return Censored(numbers, numbers >= never, np.zeros(len(values), bool))


ONE, OTHER = upto(100, 10, 100, 20, 100), upto(100, 5, 10, 100, 100)


def test_no_ratio_is_formed_with_never():
    assert np.array_equal(ONE.over(OTHER), [2, np.nan, np.nan, np.nan], equal_nan=True)
    assert np.array_equal(upto(9, 0, 1).over(upto(9, 0, 0)), [np.nan, np.inf], equal_nan=True)


def test_a_difference_with_never_is_a_bound():
    found = ONE - OTHER
    assert np.array_equal(found.values, [5, 90, -80, np.nan], equal_nan=True)
    assert found.at_least.tolist() == [False, True, False, True]
    assert found.at_most.tolist() == [False, False, True, True]


def test_a_mean_with_never_is_a_lower_bound():
    found = Censored.mean([ONE, OTHER])
    assert found.values.tolist() == [7.5, 55, 60, 100]
    assert found.at_least.tolist() == [False, True, True, True]


@pytest.mark.parametrize(("last", "expected"), [(12.0, True), (10.0, False)])
def test_a_measure_says_which_of_its_values_stand_for_never(last: float, expected: bool):
    recorded, weights = MadeUp(last=last, noise=0.0), np.full((1, 60), 1 / 60)
    found = Censored.of(measure("trials_to=1.1"), recorded, weights)
    assert found.at_least.tolist() == [expected]
    assert found.values.tolist() == [TRIALS if expected else 10]
    assert not Censored.of(measure("total_steps"), recorded, weights).at_least.any()


def test_an_interval_says_which_of_its_ends_are_bounds():
    rng = np.random.default_rng(0)
    often = upto(100, *np.where(rng.random(1000) < 0.5, 100.0, 40.0))
    assert Bounded.of(upto(100, 40), often) == (40, 40, 100, "high ≥")
    assert Bounded.of(upto(100, 100), often) == (100, 40, 100, "value ≥, high ≥")
    assert Bounded.of(upto(100, 100), upto(100, *[100] * 50)) == (100, 100, 100, "value ≥, low ≥, high ≥")
    assert Bounded.of(upto(100, 40), upto(100, 40, 40)).bounds == ""


def test_an_interval_of_differences_with_never_has_bounds_on_both_sides():
    constant = upto(1e9, *[50] * 4)
    ahead = upto(100, 100, 100, 100, 40)
    assert Bounded.of(upto(100, 100) - upto(100, 50), ahead - constant).bounds == "value ≥, high ≥"
    behind = Bounded.of(upto(100, 50) - upto(100, 100), constant - ahead)
    assert behind.bounds == "value ≤, low ≤"
    unknown = Bounded.of(upto(100, 100) - upto(100, 100), ahead - ahead)
    assert np.isnan(unknown[:3]).all()
