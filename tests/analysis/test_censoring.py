"""Numbers that stand for "never"."""

from __future__ import annotations

import numpy as np

from rl_design_space.analysis.censoring import difference, is_never, ratio

ONE, OTHER = np.array([10.0, 100.0, 20.0, 100.0]), np.array([5.0, 10.0, 100.0, 100.0])


def test_no_ratio_is_formed_with_never():
    assert np.array_equal(ratio(ONE, OTHER, 100, 100), [2, np.nan, np.nan, np.nan], equal_nan=True)
    assert np.array_equal(ratio(ONE, OTHER), [2, 10, 0.2, 1])
    assert np.array_equal(ratio(np.array([0.0, 1.0]), np.zeros(2)), [np.nan, np.inf], equal_nan=True)


def test_a_difference_with_never_is_a_bound():
    found = difference(ONE, OTHER, 100, 100)
    assert np.array_equal(found.values, [5, 90, -80, np.nan], equal_nan=True)
    assert found.at_least.tolist() == [False, True, False, False]
    assert found.at_most.tolist() == [False, False, True, False]


def test_a_measure_without_never_has_no_bounds():
    assert not is_never(np.array([1e9, np.nan]), None).any()
