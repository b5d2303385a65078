"""Orders: whether any limits would give the grades that were published."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl_design_space.analysis.orders import between, order
from rl_design_space.analysis.statistics import Estimate

GRADES = 4


def exactly(values) -> list[Estimate]:
    return [Estimate(value, value, value) for value in values]


def some_limits_give(ranks, values, larger: bool) -> bool:
    """Try all limits: grades are places between them, and which of the four grades is a place's is free."""
    signed = [value if larger else -value for value in values]
    limits = sorted({value - 0.5 for value in signed} | {max(signed) + 1})
    for chosen in combinations_with_replacement(limits, GRADES - 1):
        if [sum(value >= limit for limit in chosen) for value in signed] == list(ranks):
            return True
    return False


rows = st.integers(2, 4).flatmap(
    lambda n: st.tuples(
        st.lists(st.integers(0, GRADES - 1), min_size=n, max_size=n),
        st.lists(st.integers(0, 9), min_size=n, max_size=n),
        st.booleans(),
    )
)


@given(rows)
def test_it_agrees_with_trying_all_limits(drawn):
    ranks, values, larger = drawn
    expected = "some limits" if some_limits_give(ranks, values, larger) else "no limits"
    assert order(ranks, exactly(values), larger=larger) == expected


@given(rows, st.lists(st.floats(0, 3), min_size=8, max_size=8), st.lists(st.floats(0, 1), min_size=4, max_size=4))
def test_a_verdict_holds_for_all_values_in_the_intervals(drawn, reach, places):
    ranks, values, larger = drawn
    estimates = [Estimate(v, v - down, v + up) for v, down, up in zip(values, reach[:4], reach[4:], strict=False)]
    verdict = order(ranks, estimates, larger=larger)
    anywhere = [each.low + place * (each.high - each.low) for each, place in zip(estimates, places, strict=False)]
    if verdict != "cannot be told":
        assert order(ranks, exactly(anywhere), larger=larger) == verdict


@given(rows)
def test_a_change_of_units_does_not_matter(drawn):
    ranks, values, larger = drawn
    verdict = order(ranks, exactly(values), larger=larger)
    assert order(ranks, exactly(np.exp(values)), larger=larger) == verdict
    assert order(ranks, exactly([-value for value in values]), larger=not larger) == verdict


def test_equal_grades_ask_for_nothing():
    assert order([2, 2, 2], exactly([5, 900, -3]), larger=True) == "some limits"


def test_values_that_are_certainly_equal_cannot_have_different_grades():
    assert order([1, 3], exactly([0, 0]), larger=True) == "no limits"


def test_never_is_later_than_any_trial_but_not_than_never():
    never, soon = Estimate(100, 100, np.inf), Estimate(40, 35, 45)
    assert order([3, 1], [soon, never], larger=False) == "some limits"
    assert order([3, 1], [never, soon], larger=False) == "no limits"
    assert order([3, 1], [never, never], larger=False) == "cannot be told"


def test_an_unknown_interval_decides_nothing():
    unknown = Estimate(1.0, np.nan, np.nan)
    assert order([1, 2], [unknown, Estimate(5, 4, 6)], larger=True) == "cannot be told"


def test_limits_lie_between_neighbouring_grades():
    assert between([3, 1, 3], [40, 90, 60], larger=False) == [(60, 90)]
    assert between([1, 2, 3], [0.1, 0.4, 0.9], larger=True) == [(0.4, 0.9), (0.1, 0.4)]
    assert between([2, 2], [1, 2], larger=True) == []


@pytest.mark.parametrize("larger", [False, True])
def test_limits_in_the_gaps_give_the_order(larger: bool):
    ranks, values = [3, 1, 2, 1], [9.0, 2.0, 5.0, 1.0]
    values = values if larger else [-value for value in values]
    limits = [(low + high) / 2 for low, high in between(ranks, values, larger=larger)]
    places = [sum(value > limit if larger else value < limit for limit in limits) for value in values]
    assert places == [2, 0, 1, 0]
