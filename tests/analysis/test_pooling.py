"""Periods of several seeds are one sample, and designs that share a period are resampled together (decision 0016)."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis import pooling
from rl_design_space.analysis.averaging import curve_of_runs, estimate, mean_of_runs, pooled
from rl_design_space.analysis.pooling import Pool, Repetition
from rl_design_space.analysis.statistics import mean_estimate, percentile_interval, resample_weights
from rl_design_space.learning import LearningCurves
from rl_design_space.learning.measures import MEASURES

VALUES = np.random.default_rng(0).lognormal(size=30)


def width(found) -> float:
    return found.high - found.low


def split(values: np.ndarray, seeds: int, design: str = "a") -> tuple[list[np.ndarray], list[Repetition]]:
    """Return values as the periods of several seeds."""
    return np.split(values, seeds), [Repetition(design, seed) for seed in range(seeds)]


def test_one_seed_gives_what_it_always_gave_to_the_bit():
    assert mean_of_runs(*split(VALUES, 1)) == mean_estimate(VALUES)
    other = VALUES[::-1] ** 2
    found = mean_of_runs([VALUES, other], [Repetition("a", 0), Repetition("b", 0)])
    samples = (resample_weights(30) @ (VALUES + other)) / 2
    assert found == (np.mean([VALUES.mean(), other.mean()]), *percentile_interval(samples))


@pytest.mark.parametrize("seeds", [2, 6, 30])
def test_periods_of_many_seeds_are_as_good_as_those_of_one(seeds: int):
    assert mean_of_runs(*split(VALUES, seeds)) == mean_estimate(VALUES)


def test_designs_that_share_periods_are_paired_over_all_seeds():
    # What one gains the other loses: their mean is known exactly, if the same periods of both are resampled.
    runs = [*split(VALUES, 6)[0], *split(10 - VALUES, 6)[0]]
    repetitions = [*split(VALUES, 6, "a")[1], *split(VALUES, 6, "b")[1]]
    paired = mean_of_runs(runs, repetitions)
    assert (paired.low, paired.high) == pytest.approx((5, 5))
    others = [Repetition(design, (design, seed)) for design, seed in repetitions]
    assert width(mean_of_runs(runs, others)) > 0.1


def test_a_difference_between_designs_does_not_widen_the_interval():
    apart = [VALUES[:15], 1000 + VALUES[15:]]
    found = mean_of_runs(apart, [Repetition("a", 0), Repetition("b", 1)])
    assert found.value == pytest.approx(500 + VALUES.mean(), rel=1e-6)
    assert width(found) < 2 * width(mean_estimate(VALUES))


def test_periods_that_runs_of_different_length_share_are_paired():
    longer = np.concatenate([VALUES, VALUES])
    runs = [longer, 10 - VALUES]
    found = mean_of_runs(runs, [Repetition("60", 0), Repetition("30", 0)])
    apart = mean_of_runs(runs, [Repetition("60", 0), Repetition("30", 1)])
    assert found.value == pytest.approx(5)
    # Half of the periods of the first cancel half of what those of the second contribute.
    assert width(found) < 0.8 * width(apart)


def test_a_single_period_has_no_interval():
    assert np.isnan(mean_of_runs([VALUES[:1], VALUES[:1]], [Repetition("a", 0), Repetition("b", 0)]).low)
    low, high = curve_of_runs([VALUES[:1, np.newaxis]], [Repetition("a", 0)])
    assert np.isnan(low).all()
    assert np.isnan(high).all()


def test_a_curve_over_seeds_has_the_band_of_its_pooled_periods():
    curves = np.random.default_rng(1).lognormal(size=(30, 4))
    one = curve_of_runs([curves], [Repetition("a", 0)])
    many = curve_of_runs(*split(curves, 30))
    np.testing.assert_allclose(one, many)


def test_weights_that_do_not_fit_into_memory_are_drawn_in_parts(monkeypatch: pytest.MonkeyPatch):
    runs, repetitions = split(VALUES, 3)
    whole = Pool(repetitions, [10] * 3).resampled_means(runs)
    monkeypatch.setattr(pooling, "_AT_ONCE", 1000)
    np.testing.assert_allclose(Pool(repetitions, [10] * 3).resampled_means(runs), whole)


def test_a_measure_of_the_mean_curve_is_that_of_all_seeds_together():
    rng = np.random.default_rng(2)
    steps = (10 + 90 * np.exp(-np.arange(20) / 4) * rng.lognormal(size=(24, 20))).astype(np.int32)

    def curves(part: np.ndarray) -> LearningCurves:
        ones = np.ones((len(part), 2), np.int32)
        return LearningCurves(part, part > 0, np.full(len(part), 10, np.int32), ones, np.zeros(20))

    seeds = [curves(part) for part in np.split(steps, 12)]
    repetitions = [Repetition("a", seed) for seed in range(12)]
    for name in ("trials_to_final", "roughness"):
        one = estimate(MEASURES[name], [curves(steps)], [Repetition("a", 0)])
        many = estimate(MEASURES[name], seeds, repetitions)
        assert many == pytest.approx(one)
        assert many.low < many.high
    assert pooled(seeds).steps.tolist() == steps.tolist()
    # A second design, of the first seeds only, is resampled together with them.
    two = estimate(MEASURES["roughness"], [*seeds, *seeds[:6]], [*repetitions, *(Repetition("b", i) for i in range(6))])
    assert two.low < two.value < two.high
