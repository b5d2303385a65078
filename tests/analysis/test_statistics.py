"""Estimates over periods, and weights of the largest values."""

from __future__ import annotations

import math
import tracemalloc
import warnings
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from rl_design_space.analysis import resampling, statistics
from rl_design_space.analysis.averaging import mean_of_runs
from rl_design_space.analysis.bca import bca_interval
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.analysis.statistics import (
    Resamples,
    mean_estimate,
    mean_share_estimate,
    resample_weights,
    resampled_means,
    share_estimate,
    top_percent_weight,
    weighted_means,
)
from rl_design_space.design import DesignPoint, Direction, Linear, Task
from rl_design_space.learning import simulate
from rl_design_space.learning.measure_statistics import means_of_each
from tests.analysis.heavy_tails import periods, stored

SKEWED = np.random.default_rng(1).lognormal(size=40)


def test_the_same_values_give_the_same_interval():
    np.random.seed(1)  # noqa: NPY002 (the global generator must not matter)
    first = mean_estimate(SKEWED)
    np.random.seed(2)  # noqa: NPY002
    assert mean_estimate(SKEWED) == first
    assert mean_estimate(SKEWED, seed=1) != first


def test_the_value_is_the_mean_and_the_interval_is_around_it():
    estimate = mean_estimate(SKEWED)
    assert estimate.value == SKEWED.mean()
    assert SKEWED.min() < estimate.low < estimate.value < estimate.high < SKEWED.max()


@pytest.mark.parametrize("periods", [2, 12, 255, 500])
def test_the_interval_is_that_of_scipy_bit_for_bit(periods: int):
    values = np.random.default_rng(periods).lognormal(size=periods)
    again = stats.bootstrap((values,), np.mean, n_resamples=5000, method="BCa", rng=np.random.default_rng(7))
    assert tuple(mean_estimate(values, seed=7))[1:] == tuple(again.confidence_interval)


def test_the_interval_follows_the_skew():
    estimate = mean_estimate(SKEWED)
    assert estimate.high - estimate.value > 1.2 * (estimate.value - estimate.low)
    mirrored = mean_estimate(-SKEWED)
    assert mirrored.value - mirrored.low > 1.2 * (mirrored.high - mirrored.value)


def test_the_interval_is_corrected_for_the_skew():
    # A plain percentile interval is too low at both ends of a sample with a long right tail.
    resampled = np.random.default_rng(6).choice(SKEWED, size=(5000, len(SKEWED))).mean(axis=1)
    low, high = np.quantile(resampled, (0.025, 0.975))
    estimate = mean_estimate(SKEWED)
    assert estimate.low > low + 0.01 * (high - low)
    assert estimate.high > high + 0.04 * (high - low)


@pytest.mark.parametrize("size", [2, 3, 50, 501])
def test_intervals_are_those_of_scipy(size: int):
    values = np.random.default_rng(size).exponential(size=size) ** 3
    means = values[np.random.default_rng(0).integers(size, size=(400, size))].mean(axis=1)
    known = SimpleNamespace(bootstrap_distribution=means)
    ends = stats.bootstrap((values,), np.mean, n_resamples=0, bootstrap_result=known).confidence_interval
    assert bca_interval(values, means) == pytest.approx((ends.low, ends.high), rel=1e-12)
    for number in (0, 1, size):
        ends = stats.binomtest(number, size).proportion_ci(method="wilson")
        assert share_estimate(np.arange(size) < number)[1:] == pytest.approx((ends.low, ends.high), rel=1e-12)


def test_the_interval_agrees_with_theory_where_there_is_no_skew():
    values = np.random.default_rng(2).normal(100, 10, size=500)
    estimate = mean_estimate(values)
    half = 1.96 * values.std(ddof=1) / math.sqrt(len(values))
    assert (estimate.low, estimate.high) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.1 * half)


def test_about_ninety_five_of_a_hundred_intervals_hold_the_true_mean(monkeypatch: pytest.MonkeyPatch):
    # Enough for a share to within 0.03, and so many that the tail of 100 values a sample is what counts.
    monkeypatch.setattr(statistics, "RESAMPLES", 500)
    rng, samples = np.random.default_rng(3), 600
    true_mean = 1.0
    held = below = 0
    for seed in range(samples):
        estimate = mean_estimate(rng.exponential(true_mean, size=100), seed)
        held += estimate.low <= true_mean <= estimate.high
        below += estimate.high < true_mean
    assert 0.91 <= held / samples <= 0.98
    # An interval that ignored the skew would miss nearly always on this side.
    assert below / samples <= 0.06


def test_more_periods_make_a_narrower_interval():
    values = np.random.default_rng(4).lognormal(size=1600)
    few, many = mean_estimate(values[:100]), mean_estimate(values)
    assert many.high - many.low < 0.5 * (few.high - few.low)


@pytest.mark.parametrize("count", [2, 3, 500])
def test_equal_values_have_an_interval_without_width(count: int):
    assert mean_estimate(np.full(count, 7.0)) == (7.0, 7.0, 7.0)


def test_one_period_has_no_interval():
    estimate = mean_estimate(np.array([7.0]))
    assert estimate.value == 7.0
    assert math.isnan(estimate.low)
    assert math.isnan(estimate.high)


@settings(deadline=None, max_examples=40)
@given(values=st.lists(st.integers(1, 10_000), min_size=2, max_size=30))
def test_an_interval_is_within_the_values_and_gives_no_warning(values: list[int]):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        estimate = mean_estimate(np.array(values, dtype=float))
    # The bootstrap resamples what is there, so that not even a heavy tail leads outside.
    assert min(values) <= estimate.low <= estimate.high <= max(values)
    assert estimate.value == pytest.approx(np.mean(values))


@pytest.mark.parametrize(
    ("values", "weight"),
    [
        ([5.0] * 100, 1.0),
        ([5.0] * 500, 1.0),
        ([5.0] * 50, 1.0),
        ([1.0] * 99 + [101.0], 101 / 2),
        ([1.0] * 198 + [1.0, 801.0], 401 / 5),
        ([0.0, 0.0, 3.0], 3.0),
        ([1.0] * 100 + [300.0], 150.5 / (400 / 101)),
    ],
    ids=["equal", "more", "fewer", "one", "two", "all", "rounded up"],
)
def test_weight_of_the_largest_percent(values: list[float], weight: float):
    shuffled = np.random.default_rng(5).permutation(values)
    assert top_percent_weight(shuffled) == pytest.approx(weight)


@pytest.mark.parametrize(
    ("true", "of", "low", "high"),
    [(0, 10, 0.0, 0.2775), (1, 10, 0.0179, 0.4042), (5, 10, 0.2366, 0.7634), (10, 10, 0.7225, 1.0)],
)
def test_a_share_has_the_published_wilson_interval(true: int, of: int, low: float, high: float):
    found = share_estimate(np.arange(of) < true)
    assert found == pytest.approx((true / of, low, high), abs=1e-4)


def coverage(interval: Callable[[np.ndarray], tuple[float, float]], cell: str, size: int, samples: int) -> float:
    """Return how often an interval of the mean holds that of all periods of a cell."""
    every, rng = periods(cell), np.random.default_rng(size)
    drawn = (every[rng.integers(len(every), size=size)] for _ in range(samples))
    return float(np.mean([low <= every.mean() <= high for low, high in map(interval, drawn)]))


def ends(values: np.ndarray) -> tuple[float, float]:
    return mean_estimate(values)[1:]


@pytest.mark.parametrize(("cell", "size"), [("remaining_10_2", 20_000), ("remaining_10_3", 20_000), ("all_10_2", 5000)])
def test_intervals_of_heavy_tails_hold_the_true_mean_where_there_are_enough_periods(cell: str, size: int):
    assert coverage(ends, cell, size, 250) >= 0.93


def test_500_periods_of_a_heavy_tail_are_not_enough(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 300)
    assert coverage(ends, "remaining_10_2", 500, 150) < 0.88
    assert top_percent_weight(periods("remaining_10_2")) > 3


def test_the_interval_without_resampling_is_close_to_the_resampled_one(monkeypatch: pytest.MonkeyPatch):
    values = np.random.default_rng(7).lognormal(size=2500)
    analytic = mean_estimate(values)
    monkeypatch.setattr(statistics, "_MANY", len(values))
    resampled = mean_estimate(values)
    assert analytic == pytest.approx(resampled, abs=0.05 * (resampled.high - resampled.low))
    symmetric = mean_estimate(np.tile([-1.0, 1.0], 1250))
    assert symmetric[1:] == pytest.approx((-1.96 / 50, 1.96 / 50), rel=0.03)


@pytest.mark.parametrize("true", [0, 500])
def test_a_share_of_nothing_or_all_has_an_interval_with_a_width(true: int):
    which = np.arange(500) < true
    found = share_estimate(which)
    assert found.high - found.low == pytest.approx(0.0076, abs=1e-4)
    assert mean_share_estimate(which.astype(float)) == found
    assert mean_share_estimate(np.append(which, 0.5)) == mean_estimate(np.append(which, 0.5))
    several = [Repetition(design, 0) for design in "ab"]
    assert mean_of_runs([which.astype(float)] * 2, several, of_shares=True) == found


def test_the_stored_periods_are_those_of_the_kernel():
    point = DesignPoint(
        task=Task(goals=2, periods=300),
        exploration=Linear(k=0.02),
        representation=Direction(goals="remaining"),
        seed=2**31,
    )
    totals = simulate(point, threads=1).total_steps
    assert np.isin(totals, periods("remaining_10_2")).all()
    assert np.array_equal(stored(totals).cumsum(), np.sort(totals))


@pytest.mark.parametrize("periods", [1, 7, 500, 5000])
def test_weighted_means_are_those_of_one_product(periods: int):
    rng = np.random.default_rng(periods)
    weights, values = rng.random((50, periods)), rng.lognormal(size=periods)
    np.testing.assert_allclose(weighted_means(weights, values), weights @ values, rtol=1e-12)
    assert weighted_means(weights[:0], values).shape == (0,)
    # Reports are the same however many measures are computed together.
    many = np.tile(weights, (21, 1))[:1049]
    both = np.array([values, values[::-1]])
    assert np.array_equal(means_of_each(many, both), [weighted_means(many, each) for each in both])


@pytest.mark.parametrize("half", [slice(None), slice(1, None, 2)], ids=["all", "odd"])
def test_resamples_in_blocks_are_those_at_once_and_no_block_is_large(half: slice, monkeypatch: pytest.MonkeyPatch):
    weights = np.zeros((500, 60))
    weights[:, half] = resample_weights(len(range(60)[half]), seed=3, resamples=500)
    resamples = Resamples(60, seed=3, resamples=500, of=half)
    (whole,) = resamples.blocks()
    monkeypatch.setattr(resampling, "AT_ONCE", 1000)
    resampling._counts.cache_clear()
    blocks = list(resamples.blocks())
    assert len(blocks) > 30
    assert max(block.size for block in blocks) <= 1000
    assert np.array_equal(whole, weights)
    assert np.array_equal(np.concatenate(blocks), weights)
    values = np.random.default_rng(1).random((60, 3))
    found = resampled_means(values, seed=3, resamples=500)
    np.testing.assert_allclose(found, resample_weights(60, 3, 500) @ values, rtol=1e-12)


def test_resamples_of_many_periods_take_an_eighth_of_the_memory_of_their_weights(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(resampling, "AT_ONCE", 200_000)
    resampling._counts.cache_clear()
    tracemalloc.start()
    means = resampled_means(np.ones(20_000), resamples=200)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    resampling._counts.cache_clear()
    assert means == pytest.approx(1)
    # A byte a count, and blocks of whole numbers, of weights and of copies of them; all weights would take 32 MB.
    assert peak < 4e6 + 3.2 * 8 * resampling.AT_ONCE < 10e6
