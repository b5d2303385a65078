"""Schedules: their formulas at chosen trials, and their range for all parameters."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import Constant, Exploration, Exponential, Linear, Sigmoidal

finite = st.floats(allow_nan=False, allow_infinity=False)
not_negative = st.floats(0, allow_infinity=False)
positive = st.floats(0, exclude_min=True, allow_infinity=False)
probabilities = st.floats(0, 1)
first_trials = st.integers(0, 1000)


@pytest.mark.parametrize(
    ("exploration", "tau", "epsilon"),
    [
        (Constant(), 0, 0.1),
        (Constant(epsilon=1.0), 99, 1.0),
        (Linear(k=0.03), 0, 0.9),
        (Linear(k=0.03), 10, 0.6),
        (Linear(k=0.03), 30, 0.0),
        (Linear(k=0.03), 99, 0.0),
        (Linear(start=0.5, k=0.01), 20, 0.3),
        (Exponential(l=2.0), 0, 0.9),
        (Exponential(l=2.0), 3, 0.9 / 8),
        (Exponential(l=1.0), 99, 0.9),
        (Exponential(l=1.05), 50, 0.9 / 1.05**50),
        (Exponential(l=10.0), 99, 0.9e-99),
        (Exponential(start=0.5, l=0.5), 1, 1.0),
        (Exponential(start=0.5, l=0.5), 60, 1.0),
        (Sigmoidal(p=5.0, q=20.0), 0, 1 / (1 + math.exp(-4))),
        (Sigmoidal(p=5.0, q=20.0), 20, 0.5),
        (Sigmoidal(p=5.0, q=20.0), 40, 1 / (1 + math.exp(4))),
        (Sigmoidal(p=0.001, q=50.0), 49, 1.0),
        (Sigmoidal(p=0.001, q=50.0), 51, 0.0),
    ],
    ids=str,
)
def test_formula(exploration: Exploration, tau: int, epsilon: float):
    assert exploration.schedule(100)[tau] == pytest.approx(epsilon, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("option", [Linear, Exponential, Sigmoidal])
def test_the_first_trial_is_zero_by_default(option):
    np.testing.assert_array_equal(option(first_trial=1).schedule(9), option().schedule(10)[1:])


def test_schedules_of_the_paper_decay_monotonically():
    for exploration in (Linear(), Exponential(), Sigmoidal()):
        assert (np.diff(exploration.schedule(100)) <= 0).all()


@settings(deadline=None)
@given(
    exploration=st.one_of(
        st.builds(Constant, epsilon=probabilities),
        st.builds(Linear, start=probabilities, k=not_negative, first_trial=first_trials),
        st.builds(Exponential, start=probabilities, l=positive, first_trial=first_trials),
        st.builds(Sigmoidal, p=positive, q=finite, first_trial=first_trials),
    ),
    trials=st.integers(1, 500),
)
def test_any_allowed_parameters_yield_probabilities(exploration: Exploration, trials: int):
    epsilon = exploration.schedule(trials)
    assert epsilon.shape == (trials,)
    assert epsilon.dtype == np.float64
    assert ((epsilon >= 0) & (epsilon <= 1)).all()


def test_a_growing_schedule_that_starts_at_zero_stays_there():
    # The power overflows long before, and zero times infinity is no number.
    assert Exponential(start=0.0, l=0.1).schedule(400).tolist() == [0.0] * 400


@pytest.mark.parametrize("exploration", [Linear(k=1e308), Sigmoidal(p=1e-308, q=1e10)], ids=str)
def test_a_steep_schedule_raises_no_warning(exploration: Exploration):
    epsilon = exploration.schedule(100)
    assert ((epsilon >= 0) & (epsilon <= 1)).all()
