"""Error probabilities of combined parts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rl_design_space.analysis.bounds import Bounds, known
from rl_design_space.analysis.placebo import placebo
from rl_design_space.analysis.tested import all_of, any_of, bounds_in_range, every_in_range, in_range

RNG = np.random.default_rng(3)
NOISE = 0.1 * RNG.normal(size=2000)


def part(value: float):
    return in_range("a statistic", value, value + NOISE, 1.0, math.inf)


SURE, UNCLEAR, FALSE = part(2.0), part(1.05), part(0.0)


def test_any_of_holds_by_one_and_fails_by_all():
    assert any_of("-", [SURE, FALSE]).state == "holds"
    assert any_of("-", [UNCLEAR, FALSE]).state == "unclear"
    assert any_of("-", [FALSE, FALSE]).state == "fails"
    # One of three may hold by chance, so its probability counts three times; that all fail, the best of them says.
    found = any_of("-", [UNCLEAR, FALSE, FALSE])
    assert found.p_claim == min(1.0, 3 * UNCLEAR.p_claim)
    assert found.p_other == UNCLEAR.p_other


def test_all_of_fails_by_one_and_holds_by_all():
    assert all_of("-", [SURE, FALSE]).state == "fails"
    assert all_of("-", [SURE, UNCLEAR]).state == "unclear"
    found = all_of("-", [SURE, UNCLEAR])
    assert found.p_claim == UNCLEAR.p_claim
    assert found.p_other == min(1.0, 2 * UNCLEAR.p_other)


def test_any_of_is_wrong_as_rarely_as_it_says():
    # Five true values at the very limit of a range: no more than 5 % of data sets may claim that one is inside.
    wrong = 0
    for _ in range(300):
        values = 1.0 + 0.1 * RNG.normal(size=5)
        parts = [in_range("-", value, value + NOISE, 1.0, math.inf) for value in values]
        wrong += any_of("-", parts).p_claim < 0.05
    assert wrong / 300 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 300)


def test_all_of_many_statistics_fail_without_a_correction_for_their_number():
    value = known(np.full((9, 1), 1.0))
    samples = known(1.0 + 0.1 * RNG.normal(size=(9, 2000)))
    calm, _ = every_in_range("-", value, samples, -math.inf, 1.05)
    assert calm.p_other > 0.5
    value.low[4] += 1.0
    samples.low[4] += 1.0
    tested, decisive = every_in_range("-", value, samples, -math.inf, 1.05)
    assert (decisive, tested.value, tested.state) == (4, 2.0, "fails")
    assert tested.p_other == pytest.approx(1 / 2001)  # not nine times that


def test_all_of_many_statistics_are_wrong_as_rarely_as_they_say():
    wrong = 0
    for _ in range(300):
        values = 1.05 + 0.1 * RNG.normal(size=(6, 1))  # every true value is at the limit
        samples = known(values + 0.1 * RNG.normal(size=(6, 500)))
        wrong += every_in_range("-", known(values), samples, -math.inf, 1.05)[0].p_other < 0.05
    assert wrong / 300 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 300)


def test_a_resample_of_which_only_a_bound_is_known_counts_if_the_bound_decides():
    low, high = np.array([3.0] * 10), np.array([np.inf] * 10)
    value = Bounds(low[:1], high[:1])
    assert bounds_in_range("-", value, Bounds(low, high), 2.0, math.inf).state == "holds"
    assert bounds_in_range("-", value, Bounds(low, high), 0.0, 2.0).state == "fails"
    unknown = bounds_in_range("-", value, Bounds(low, high), 0.0, 4.0)
    assert (unknown.state, unknown.p_claim, unknown.p_other) == ("unclear", 1.0, 1.0)


def test_placebo_by_hand():
    # Two grids of which no and half of the others would pass, one of which all would.
    found = placebo([(True, 0, 9), (True, 1, 2), (False, 3, 3)])
    assert found == (2, 3, pytest.approx(0.5))  # the third always passes, so the second must: 1/2
    assert placebo([(True, 0, 9), (True, 1, 2), (True, 3, 3)]).chance == 0.0
    assert placebo([]) is None


def test_a_ratio_to_0_is_infinite_in_some_resamples_and_still_has_an_interval():
    samples = np.where(np.arange(2000) < 100, np.inf, 2.0 + NOISE)
    tested = in_range("a / 0", 2.0, samples, 1.0, math.inf)
    assert (tested.state, tested.ci_high) == ("holds", math.inf)
    assert 1.7 < tested.ci_low < 2.0
