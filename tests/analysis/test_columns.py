"""Numbers of designs by block are those of an array with NaN."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.columns import Columns, cut
from rl_design_space.analysis.leaders import leading


@pytest.fixture
def each() -> np.ndarray:
    """Four designs of 40 periods, three of 25, and one whose periods begin later and have a gap."""
    found = np.random.default_rng(0).normal(10, 1, (40, 8))
    found[7, 1] = found[3, 4] = 1e6
    found[25:, [1, 4, 6]] = np.nan
    found[[0, 1, 2, 11], 5] = np.nan
    return found


def test_counts_and_means_are_those_of_the_array(each: np.ndarray):
    columns = Columns.of_array(each)
    assert len(columns.blocks) == 3
    assert not columns.is_even
    np.testing.assert_array_equal(columns.counts, (~np.isnan(each)).sum(axis=0))
    np.testing.assert_array_equal(columns.means, np.nanmean(each, axis=0))
    np.testing.assert_array_equal((-columns).means, -columns.means)


def test_columns_of_designs_are_those_of_the_array(each: np.ndarray):
    rows = [np.flatnonzero(~np.isnan(column)) for column in each.T]
    columns = Columns.of_designs([(row, column[row]) for row, column in zip(rows, each.T, strict=True)], 40)
    np.testing.assert_array_equal(columns.means, Columns.of_array(each).means)
    np.testing.assert_array_equal(leading(columns), leading(Columns.of_array(each)))


def test_periods_in_common(each: np.ndarray):
    found = Columns.of_array(each).in_common(np.array([1, 3, 5]))
    rows = ~np.isnan(each[:, [1, 3, 5]]).any(axis=1)
    np.testing.assert_array_equal(found, each[rows][:, [1, 3, 5]])


def test_designs_with_far_outliers_are_repeated_without_them(each: np.ndarray):
    both, outlying = Columns.of_array(each).with_cut()
    assert outlying.tolist() == [1, 4]
    assert both.designs == 10
    less, _ = cut(each[:25, [1, 4]])
    np.testing.assert_allclose(both.means, [*np.nanmean(each, axis=0), *less.mean(axis=0)])
    np.testing.assert_array_equal(both.counts[8:], [25, 25])
