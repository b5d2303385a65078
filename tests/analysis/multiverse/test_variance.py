"""The decomposition of verdicts, by hand."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rl_design_space.analysis.multiverse.variance import decompose, first_order, total

KEYS = ["ties", "update", "goals"]
READINGS = [frozenset(), *(frozenset({i}) for i in range(3)), *map(frozenset, combinations(range(3), 2))]
JUDGEMENTS = ["measure", "limits"]


def shares(holds) -> dict[str, float]:
    """Return the shares of a verdict that is a function of reading, measure (of 2) and limits (of 3)."""
    verdicts = np.array([[[float(holds(r, m, t)) for t in range(3)] for m in range(2)] for r in READINGS])
    return {" × ".join(sorted(p.factors)): p.share for p in decompose(verdicts, READINGS, KEYS, JUDGEMENTS)}


def test_a_verdict_of_one_reading_hangs_on_it_alone():
    assert shares(lambda reading, m, t: 0 in reading) == {"ties": pytest.approx(1)}


def test_a_verdict_of_one_measure_hangs_on_it_alone():
    assert shares(lambda reading, m, t: m == 1) == {"measure": pytest.approx(1)}


def test_either_or_of_two_measures_and_limits_is_interaction():
    # m, t in {0, 1, 2}: mean 1/2 for each m, but for the limits 0, of which nothing depends on m.
    found = shares(lambda reading, m, t: (m == 1) == (t == 1))
    assert found == {"limits × measure": pytest.approx(8 / 9), "measure": pytest.approx(1 / 9)}


def test_a_verdict_of_two_readings_together():
    # x·y with chance 1/3 each: variances by the closed form.
    p = 1 / 3
    whole = p**2 * (1 - p**2)
    alone = p**2 * p * (1 - p)
    found = shares(lambda reading, m, t: {0, 1} <= reading)
    assert found["ties"] == found["update"] == pytest.approx(alone / whole)
    assert found["ties × update"] == pytest.approx((p * (1 - p)) ** 2 / whole)
    assert sum(found.values()) == pytest.approx(1)


def test_a_reading_that_acts_under_one_measure_alone():
    found = shares(lambda reading, m, t: 2 in reading and m == 0)
    assert set(found) == {"goals", "measure", "goals × measure"}
    assert found["goals"] == pytest.approx(found["goals × measure"])


def test_alternatives_of_one_place_are_one_factor_and_the_same_verdict_hangs_on_nothing():
    readings = [frozenset(), frozenset({0}), frozenset({1})]
    parts = decompose(np.array([0.0, 1, 1]), readings, ["propagation", "propagation"], [])
    assert first_order(parts, "propagation") == total(parts, "propagation") == pytest.approx(1)
    assert decompose(np.ones(3), readings, ["propagation", "propagation"], []) == []
