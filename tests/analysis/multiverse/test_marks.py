"""Marks and the choices that they name."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.multiverse.marks import Mark, marked

N = 100
NUMBERS = np.arange(N)
SURE = np.ones(N)


def choices(**which: np.ndarray) -> dict[str, np.ndarray]:
    return {name: np.asarray(made) for name, made in which.items()}


def test_a_claim_that_holds_almost_everywhere_holds():
    assert marked(NUMBERS >= 5, SURE, {}).mark == Mark.HOLDS


def test_a_claim_that_clearly_fails_everywhere_does_not_hold():
    assert marked(NUMBERS < 0, SURE, {}).mark == Mark.NOWHERE


@pytest.mark.parametrize("holds", [NUMBERS < 0, NUMBERS < 30])
def test_a_claim_whose_specifications_are_all_unclear_cannot_be_told(holds: np.ndarray):
    assert marked(holds, np.full(N, 0.6), {}).mark == Mark.OPEN


def test_a_claim_that_holds_too_often_to_fail_but_nowhere_clearly_cannot_be_told():
    certainty = np.where(NUMBERS < 20, 0.8, 1.0)
    assert marked(NUMBERS < 3, certainty, {}).mark == Mark.NOWHERE
    assert marked(NUMBERS < 20, certainty, {}).mark == Mark.OPEN


def test_nothing_measured_cannot_be_told():
    assert marked(np.zeros(0, bool), np.zeros(0), {}).mark == Mark.OPEN


def test_the_choice_under_which_a_claim_holds_is_named():
    found = marked(NUMBERS < 20, SURE, choices(first=NUMBERS < 20, half=NUMBERS < 50, tenth=NUMBERS < 10))
    assert (found.mark, found.choices, found.within, found.share) == (Mark.UNDER, ("first",), 1.0, 0.2)


def test_two_choices_are_named_where_one_is_not_enough():
    even = NUMBERS % 2 == 0
    found = marked((NUMBERS < 50) & even, SURE, choices(half=NUMBERS < 50, even=even))
    assert (found.choices, found.within) == (("half", "even"), 1.0)


def test_the_best_choice_is_named_where_no_two_are_enough():
    found = marked(NUMBERS % 3 == 0, SURE, choices(half=NUMBERS < 50, third=NUMBERS % 6 < 4))
    assert found.choices == ("third",)
    assert found.within == pytest.approx(0.5, abs=0.02)
