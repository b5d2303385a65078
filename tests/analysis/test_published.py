"""Comparison of measured with published values, on periods built by hand."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.published import COLUMNS, compare_with_published
from rl_design_space.analysis.statistics import mean_estimate, share_estimate, top_percent_weight

VALUES = np.array([20.0, 30.0, 40.0, 30.0])
FAILED = np.array([False, False, True, False])


def test_a_measured_value_has_its_statistics():
    found, estimate = compare_with_published(25.0, VALUES, FAILED), mean_estimate(VALUES)
    assert tuple(found) == COLUMNS
    assert (found["paper"], found["measured"]) == (25.0, 30.0)
    assert (found["ci_low"], found["ci_high"]) == (estimate.low, estimate.high)
    assert found["ratio"] == pytest.approx(30 / 25)
    assert (found["failed_periods"], found["failed_low"], found["failed_high"]) == share_estimate(FAILED)
    assert found["failed_periods"] == 0.25
    assert found["top_percent"] == top_percent_weight(VALUES)


def test_a_value_that_was_not_measured_is_not_a_number():
    found = compare_with_published(25.0)
    assert (tuple(found), found.pop("paper")) == (COLUMNS, 25.0)
    assert np.isnan(list(found.values())).all()


def test_the_order_of_the_periods_does_not_matter_for_the_value():
    one, other = (compare_with_published(25.0, each, FAILED) for each in (VALUES, VALUES[::-1]))
    assert one["measured"] == other["measured"]


def test_a_single_period_has_a_value_and_no_interval():
    found = compare_with_published(25.0, np.array([50.0]), np.array([False]))
    assert (found["measured"], found["ratio"]) == (50.0, 2.0)
    assert np.isnan([found["ci_low"], found["ci_high"]]).all()
