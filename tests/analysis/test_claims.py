"""Verdicts on claims: reproduced, not reproduced, undecided."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rl_design_space.analysis.claims import Verdict, exact, holm, in_range, judge

RNG = np.random.default_rng(1)
SAMPLES = RNG.normal(size=5000)


def part(value: float, spread: float = 0.1, low: float = 1.0, high: float = math.inf):
    return in_range("a statistic", value, value + spread * SAMPLES, low, high)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [(2.0, Verdict.REPRODUCED), (0.0, Verdict.NOT_REPRODUCED), (1.05, Verdict.UNDECIDED), (0.95, Verdict.UNDECIDED)],
)
def test_a_verdict_follows_the_data(value: float, verdict: Verdict):
    finding = judge({"claim": [part(value)]})["claim"]
    assert finding.verdict == verdict
    assert finding.decisive.value == value


@pytest.mark.parametrize(("value", "state"), [(2.0, "holds"), (0.0, "fails"), (1.05, "unclear")])
def test_the_state_of_a_part_follows_its_interval(value: float, state: str):
    assert part(value).state == state


def test_a_range_has_two_ends():
    verdicts = [judge({"c": [part(value, high=3.0)]})["c"].verdict for value in (0.0, 2.0, 4.0)]
    assert verdicts == [Verdict.NOT_REPRODUCED, Verdict.REPRODUCED, Verdict.NOT_REPRODUCED]


def test_a_claim_holds_if_all_of_its_parts_do():
    sure, false, unclear = part(2.0), part(0.0), part(1.05)
    assert judge({"c": [sure, sure]})["c"].verdict == Verdict.REPRODUCED
    failed = judge({"c": [sure, false]})["c"]
    assert (failed.verdict, failed.decisive) == (Verdict.NOT_REPRODUCED, false)
    open_ = judge({"c": [sure, unclear]})["c"]
    assert (open_.verdict, open_.decisive) == (Verdict.UNDECIDED, unclear)
    assert judge({"c": [unclear, false]})["c"].verdict == Verdict.NOT_REPRODUCED


def test_verdicts_on_many_claims_need_stronger_evidence():
    almost = part(1.0 + 0.1 * 2.3)  # sure enough alone, by a one-sided chance of about 1 %
    assert judge({"c": [almost]})["c"].verdict == Verdict.REPRODUCED
    others = {f"other {i}": [almost] for i in range(9)}
    assert judge({"c": [almost], **others})["c"].verdict == Verdict.UNDECIDED


def test_a_claim_without_measurements_is_undecided_and_does_not_affect_others():
    findings = judge({"none": [], "sure": [part(2.0)]})
    assert findings["none"].verdict == Verdict.UNDECIDED
    assert findings["none"].decisive is None
    assert findings["sure"].verdict == Verdict.REPRODUCED


@pytest.mark.parametrize(("value", "verdict"), [(1.0, Verdict.REPRODUCED), (0.99, Verdict.NOT_REPRODUCED)])
def test_an_exact_statistic_is_decided(value: float, verdict: Verdict):
    finding = judge({"c": [exact("a share", value, 1.0, 1.0)]})["c"]
    assert (finding.verdict, finding.decisive.ci_low) == (verdict, value)


def test_resampling_never_gives_a_probability_of_zero():
    assert part(100.0).p_claim == pytest.approx(1 / 5001)


@pytest.mark.parametrize("value", [math.nan, 2.0])
def test_an_undefined_statistic_is_undecided(value: float):
    samples = np.where(np.arange(5000) < 10, np.nan, 2.0)
    tested = in_range("0 / 0", value, samples, 1.0, math.inf)
    assert tested.state == "unclear"
    assert judge({"c": [tested]})["c"].verdict == Verdict.UNDECIDED


def test_holm_by_hand():
    assert holm({"a": 0.01, "b": 0.04, "c": 0.03}) == {"a": 0.03, "c": 0.06, "b": 0.06}
    assert holm({}) == {}


@given(st.dictionaries(st.text(max_size=3), st.floats(0, 1), max_size=8))
def test_holm_keeps_the_order_and_is_between_no_correction_and_bonferroni(chances: dict[str, float]):
    adjusted = holm(chances)
    for name, chance in chances.items():
        assert chance <= adjusted[name] <= min(1.0, chance * len(chances)) + 1e-12
    ranked = sorted(chances, key=chances.__getitem__)
    assert [adjusted[name] for name in ranked] == sorted(adjusted.values())
