"""Measures of periods, compared with numbers computed by hand."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import ALIASES, MEASURES, CurveMeasure, measure
from tests.analysis.made_up import TRIALS, MadeUp

EQUAL = np.full((1, 60), 1 / 60)
PLAIN = MadeUp(last=12.0, first=200.0, until=5, noise=0.0)


def value(name: str, recorded: MadeUp = PLAIN) -> float:
    return float(measure(name).samples(recorded, EQUAL)[0])


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("total_steps", 5 * 200 + 15 * 12),
        ("total_steps_scaled", (5 * 200 + 15 * 12) / 2),
        ("late_steps", 12),
        ("failed_trials", 0),
        ("failed_periods", 0),
        ("final_steps_over_optimum", 1.2),
        ("final_over_optimum", 1.2),
        ("final_failed", 0),
        ("not_near_optimum", 1),
        ("outliers", 0),
        ("trials_to_final", 5),
        ("trials_to_optimum", TRIALS),  # 1.2 is not near
    ],
)
def test_measures_by_hand(name: str, expected: float):
    assert value(name) == pytest.approx(expected)


def test_failures_outliers_and_periods_away_from_the_optimum_are_shares():
    assert value("final_failed", MadeUp(failed=0.25)) == pytest.approx(0.25)
    assert value("outliers", MadeUp(until=15, noise=0.0)) == 0  # 100 steps are just 10 times the optimum
    assert value("outliers", MadeUp(first=101.0, until=15, noise=0.0)) == pytest.approx(0.5)
    assert value("not_near_optimum", MadeUp(last=10.0, noise=0.0)) == 0


def of_curve(name: str, curves: np.ndarray) -> np.ndarray:
    found = MEASURES[name]
    assert isinstance(found, CurveMeasure)
    return found.of(curves)


def test_a_curve_has_converged_when_it_stays_near_its_level():
    curves = np.array([[9.0, 1.0, 9.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0, 1.0], [9.0, 9.0, 9.0, 9.0, 9.0]])
    assert of_curve("trials_to_optimum", curves).tolist() == [3, 0, 5]


def test_a_smooth_curve_is_less_rough():
    smooth, rough = np.exp(-np.linspace(0, 2, 50)) + 1, 1 + 0.5 * (np.arange(50) % 2)
    assert of_curve("roughness", smooth) < of_curve("roughness", rough) / 10
    assert of_curve("roughness", np.exp(np.arange(9.0))) == pytest.approx(0)


def test_an_alias_names_the_same_measure():
    assert {alias: measure(alias) for alias in ALIASES} == {alias: MEASURES[name] for alias, name in ALIASES.items()}
    with pytest.raises(ConfigError, match="did you mean total_steps"):
        measure("totl_steps")


@pytest.mark.parametrize("name", MEASURES)
def test_a_measure_is_the_mean_of_its_numbers_of_periods(name: str):
    each = measure(name).each(PLAIN)
    assert (each is None) == isinstance(MEASURES[name], CurveMeasure)
    if each is not None:
        assert each.shape == (60,)
        assert value(name) == pytest.approx(each.mean())


@pytest.mark.parametrize("name", MEASURES)
def test_resamples_scatter_around_the_value(name: str):
    weights = resample_weights(60)
    samples = measure(name).samples(MadeUp(noise=0.3), weights)
    assert samples.shape == (len(weights),)
    assert samples.min() - 1e-9 <= value(name, MadeUp(noise=0.3)) <= samples.max() + 1e-9


def test_weights_are_those_of_whole_periods_and_reproducible():
    weights = resample_weights(7, seed=3, resamples=50)
    assert np.allclose(weights.sum(axis=1), 1)
    assert np.allclose(weights * 7, np.round(weights * 7))
    assert np.array_equal(weights, resample_weights(7, seed=3, resamples=50))
    assert not np.array_equal(weights, resample_weights(7, seed=4, resamples=50))
    with pytest.raises(ValueError, match="read-only"):
        weights[0, 0] = 1
