"""Leaders chosen before the periods by which designs are compared with them."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis import leaders
from rl_design_space.analysis.best import best_means
from rl_design_space.analysis.columns import Columns, groups


def leading(each: np.ndarray) -> np.ndarray:
    return leaders.leading(Columns.of_array(each))


def behind_leaders(each: np.ndarray, error: float) -> np.ndarray:
    return leaders.behind_leaders(Columns.of_array(each), error)


def test_the_leaders_of_a_period_are_chosen_by_those_before_it():
    rng = np.random.default_rng(0)
    each = rng.normal(size=(12, 9))
    found = leading(each)
    assert np.isnan(found[:5]).all()
    for period in range(5, 12):
        first = np.argsort(each[:period].mean(axis=0))[:3]  # the root of 9
        assert found[period] == pytest.approx(each[period, first].mean())
    each[8:, :5] = np.nan  # of four designs, two lead
    first = 5 + np.argsort(each[:10, 5:].mean(axis=0))[:2]
    assert leading(each)[10] == pytest.approx(each[10, first].mean())
    assert leading(each)[:8] == pytest.approx(found[:8], nan_ok=True)


@pytest.mark.parametrize("tail", [0, 1], ids=["normal", "skewed"])
def test_equal_designs_are_behind_no_more_often_than_the_error_and_worse_ones_are(tail: int):
    rng = np.random.default_rng(1)
    lost = []
    for race in range(60):
        noise = rng.lognormal(0, 1, (25, 80)) / 2.16 if tail else rng.normal(size=(25, 80))
        each = 10 + rng.normal(size=(25, 1)) + noise
        lost.append(behind_leaders(each, 0.02).mean())
        if race < 5:
            each[:, 70:] += 2
            assert behind_leaders(each, 0.02)[70:].mean() > 0.8
    assert np.mean(lost) <= 0.02 + 2 * np.std(lost) / np.sqrt(len(lost))


def test_a_design_with_too_few_periods_is_never_behind():
    each = np.random.default_rng(2).normal(size=(30, 4)) + np.array([0, 1, 2, 50])
    each[6:, 3] = np.nan
    assert not behind_leaders(each, 0.05)[3]
    assert behind_leaders(each[:5], 0.05).tolist() == [False] * 4


def test_the_final_set_is_without_designs_that_stopped_behind_the_leaders():
    rng = np.random.default_rng(3)
    each = 10 + rng.normal(size=(200, 1)) + rng.normal(size=(200, 60)) + np.r_[np.zeros(20), np.full(40, 1.2)]
    each[25:, 20:] = np.nan
    stopped = behind_leaders(each, 0.0025)
    assert stopped[20:].any()
    found = best_means(each).inside
    assert not found[stopped].any()
    assert found[:20].sum() >= 19


def test_designs_are_grouped_by_the_periods_that_they_have():
    has = np.random.default_rng(3).random((19, 40)) < 0.5
    has[:, 20:] = has[:, [0]]
    patterns, group = groups(has)
    expected, of_each = np.unique(has, axis=1, return_inverse=True)
    np.testing.assert_array_equal(patterns, expected.T)
    np.testing.assert_array_equal(group, of_each)
