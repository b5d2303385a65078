"""Statistics over periods, compared with NumPy on whole resamples."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_statistics import FORMS, IQM, MEAN, MEDIAN, statistic

RNG = np.random.default_rng(1)


def equal(periods: int) -> np.ndarray:
    return np.full((1, periods), 1 / periods)


@pytest.mark.parametrize("periods", [1, 2, 3, 7, 50, 1001])
def test_the_median_under_weights_is_that_of_the_drawn_periods(periods: int):
    values = np.round(RNG.lognormal(1, 1, size=(periods, 3)))  # many are equal
    counts = RNG.multinomial(periods, np.full(periods, 1 / periods), size=8)
    expected = [np.median(np.repeat(values, each, axis=0), axis=0) for each in counts]
    assert np.array_equal(MEDIAN.of(values, counts / periods), expected)
    assert np.array_equal(MEDIAN.of(values[:, 0], counts / periods), np.array(expected)[:, 0])
    assert MEDIAN.of(values, equal(periods))[0] == pytest.approx(np.median(values, axis=0))


def test_the_median_is_found_far_from_the_middle_of_the_periods_as_well():
    values = np.arange(2000.0)
    weights = np.zeros((3, 2000))
    weights[0, 5], weights[1, 1995], weights[2, [3, 1000]] = 1, 1, 0.5
    assert MEDIAN.of(values, weights).tolist() == [5, 1995, (3 + 1000) / 2]


@pytest.mark.parametrize("periods", [9, 40, 300])
def test_the_median_of_periods_some_of_which_seldom_have_weight(periods: int):
    values = np.round(RNG.lognormal(1, 1, size=(2 * periods, 4)) * np.repeat([[1.0], [5.0]], periods, axis=0))
    counts = RNG.multinomial(periods, np.full(periods, 1 / periods), size=30)
    which = RNG.random((30, 1)) < 0.1
    counts = 5 * np.concatenate([np.where(which, 0, counts), np.where(which, counts, 0)], axis=1)
    counts[:, 0] += 1  # so that weights are multiples of a fifth of one period's
    expected = [np.median(np.repeat(values, each, axis=0), axis=0) for each in counts]
    assert np.array_equal(MEDIAN.of(values, counts / counts.sum(axis=1, keepdims=True)), expected)


def test_slices_are_means_of_the_periods_inside():
    values = RNG.permutation(np.arange(200.0))
    assert MEAN.of(values, equal(200))[0] == pytest.approx(99.5)
    assert IQM.of(values, equal(200))[0] == pytest.approx(np.arange(50, 150).mean())
    assert statistic("cvar=1").of(values, equal(200))[0] == pytest.approx(198.5)
    assert statistic("cvar=5").of(values, equal(200))[0] == pytest.approx(np.arange(190, 200).mean())
    assert statistic("cvar=100").of(values, equal(200))[0] == pytest.approx(99.5)
    # 1 % of 50 periods is half a period.
    assert statistic("cvar=1").of(values[:50], equal(50))[0] == pytest.approx(values[:50].max())


def test_the_worst_periods_are_the_smallest_where_the_largest_are_best():
    assert statistic("cvar=5", largest_is_best=True).of(np.arange(100.0), equal(100))[0] == pytest.approx(2)


@pytest.mark.parametrize("name", FORMS)
def test_equal_values_have_that_value(name: str):
    assert statistic(name).name == name
    weights = RNG.dirichlet(np.ones(30), size=5)
    assert statistic(name).of(np.full(30, 7.0), weights) == pytest.approx(7)


@pytest.mark.parametrize("name", ["cvar", "cvar=0", "cvar=101", "cvar=x", "mode", ""])
def test_another_statistic_is_refused(name: str):
    with pytest.raises(ConfigError, match=r"statistic=.*: should be among mean, median, iqm, cvar=1, cvar=5"):
        statistic(name)
