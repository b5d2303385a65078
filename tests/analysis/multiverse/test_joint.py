"""Joint specifications and placebos."""

from __future__ import annotations

import math

import numpy as np
import pytest

from rl_design_space.analysis.multiverse.joint import Outcomes, Slot, as_good, best_joint, placebo

#: Readings, measures, statistics, thresholds.
SHAPE = (3, 2, 1, 2)
FIXED = (3, 1, 2)
EVERY = np.ones(FIXED, bool)
DEPARTURES = np.add.outer(np.arange(3), np.zeros((1, 2), int))


def where(*place: object) -> np.ndarray:
    held = np.zeros(SHAPE, bool)
    held[place] = True
    return held


ALWAYS = np.ones(SHAPE, bool)


def named(claim: str, real: np.ndarray, others: np.ndarray, values: int = 10) -> Outcomes:
    """A claim that one of ten values is the best, and where it and the others hold."""
    slot = Slot(0, {value: others if value else real for value in range(values)})
    return Outcomes(claim, "best", ALWAYS, (slot,))


def test_most_claims_hold_under_the_joint_specification_with_the_fewest_departures():
    claims = [
        Outcomes("a", "fast", where(slice(1, 3))),
        Outcomes("b", "best", where(slice(None), 1)),
        Outcomes("c", "fast", where(0)),
    ]
    joint = best_joint(claims, DEPARTURES, EVERY)
    assert (joint.reading, joint.measures, joint.claims) == (0, {"fast": 0, "best": 1}, ("b", "c"))


def test_a_search_keeps_to_what_may_be_chosen():
    claims = [Outcomes("a", "fast", where(2)), Outcomes("b", "fast", where(2))]
    assert best_joint(claims, DEPARTURES, EVERY).reading == 2
    assert best_joint(claims, DEPARTURES, EVERY & (DEPARTURES == 0)).claims == ()


def test_claims_that_hold_by_the_papers_own_values_keep_holding_against_placebos():
    claims = [named("k", ALWAYS, ~ALWAYS), named("l", ALWAYS, ~ALWAYS)]
    joint = best_joint(claims, DEPARTURES, EVERY)
    found = placebo(claims, joint, EVERY)
    assert (len(joint.claims), found.searched, found.same, found.draws) == (2, 0, 0, 81)
    assert as_good(claims[0]) == 0


def test_values_that_are_as_good_as_any_other_are_nothing_special():
    claims = [named("k", ALWAYS, ALWAYS)]
    assert placebo(claims, best_joint(claims, DEPARTURES, EVERY), EVERY).searched == 1
    assert as_good(claims[0]) == 1


def test_a_placebo_is_searched_as_widely_as_the_paper():
    # The real value holds in one specification, each other one in another.
    claims = [named("k", where(0, 0), where(2, 1))]
    found = placebo(claims, best_joint(claims, DEPARTURES, EVERY), EVERY)
    assert (found.searched, found.same) == (1, 0)


def test_draws_agree_with_the_list_of_all_placebos():
    few = named("few", ALWAYS, ~ALWAYS)
    one_in_nine = Slot(0, {value: ALWAYS if value < 2 else ~ALWAYS for value in range(10)})
    claims = [few, *(Outcomes(f"c{i}", "best", ALWAYS, (one_in_nine,)) for i in range(4))]
    found = placebo(claims, best_joint(claims, DEPARTURES, EVERY), EVERY)
    assert found.draws == 10_000  # of 59,049
    assert found.mean == pytest.approx(4 / 9, abs=0.03)
    assert placebo(claims, best_joint(claims, DEPARTURES, EVERY), EVERY) == found


def test_a_claim_without_a_best_value_has_no_placebo():
    claims = [Outcomes("a", "fast", ALWAYS)]
    assert math.isnan(as_good(claims[0]))
