"""Likelihood of published numbers: densities, floor, and recovery of the true reading."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from rl_design_space.analysis.likelihood import PERIODS, STRAY, joint_fit, log_density

#: Cells that a heavy tail shapes, as one period in a hundred does in the direction cells of Table 4.
NAMES = ("light", "skewed", "heavy")


def periods_of(name: str, rng: np.random.Generator, number: int) -> np.ndarray:
    values = 10_000 * rng.lognormal(0, 0.25 if name == "light" else 0.5, number)
    return values + (rng.random(number) < 0.01) * 500_000 if name == "heavy" else values


def exact(values: np.ndarray, size: int, stray: float = STRAY) -> np.ndarray:
    """Return quantiles of resampled means, and their log density by brute force."""
    rng = np.random.default_rng(1)
    means = rng.choice(values, (20_000, size)).mean(axis=1)
    at = np.quantile(means, [0.02, 0.1, 0.5, 0.9, 0.98])
    return np.array([at, stats.gaussian_kde(np.log(means))(np.log(at))])


@pytest.mark.parametrize("name", NAMES)
def test_the_density_is_that_of_resampled_means(name: str):
    values = periods_of(name, np.random.default_rng(0), 600)
    size = 300  # means of 200 periods: half of the measured ones count as often as the published ones
    at, density = exact(values, 200)
    found = np.array([log_density(each, values, [size])[0] for each in at])
    assert np.abs(found - np.log(density)).max() < (0.5 if name == "heavy" else 0.15)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [100, 2000])
def test_the_density_integrates_to_one(name: str, size: int):
    values = periods_of(name, np.random.default_rng(0), 400)
    at = np.linspace(np.log(values.mean()) - 1.2, np.log(values.mean()) + 1.2, 301)
    density = [np.exp(log_density(np.exp(each), values, [size], stray=0)[0]) for each in at]
    assert np.trapezoid(density, at) == pytest.approx(1, abs=0.02)


@settings(max_examples=20)
@given(st.floats(1e-6, 1e6), st.integers(0, 20))
def test_neither_the_unit_nor_the_order_of_periods_matters(scale: float, seed: int):
    rng = np.random.default_rng(seed)
    values = periods_of("heavy", rng, 50)
    expected = log_density(11_000, values)
    assert log_density(11_000 * scale, rng.permutation(values) * scale) == pytest.approx(expected, rel=1e-6)


def test_a_number_that_no_mean_comes_near_counts_the_floor():
    values = periods_of("light", np.random.default_rng(0), 200)
    floor = np.log(STRAY / (2 * np.log(10)))
    for far in (values.min() / 2, values.max() * 2, values.max() * 0.99):
        assert log_density(far, values) == pytest.approx(floor)
    assert log_density(values.mean(), values).min() > 1
    assert log_density(10, np.full(20, 10.0)) == pytest.approx(floor)


def test_few_measured_periods_make_the_density_as_wide_as_their_mean_is_uncertain():
    values = periods_of("light", np.random.default_rng(0), 100)
    few, many = (log_density(values.mean() * 1.08, each, [2000])[0] for each in (values, np.tile(values, 20)))
    assert few > many + 2


def drawn(rng: np.random.Generator, scales: dict[str, float], number: int) -> dict[str, list[np.ndarray]]:
    """Return measured periods of a light and a heavy panel of six cells each, their means scaled."""
    return {name: [scale * periods_of(name, rng, number) for _ in range(6)] for name, scale in scales.items()}


def fitted(measured: dict[str, list[np.ndarray]], published: dict[str, list[float]]):
    return joint_fit(
        {
            panel: np.array([log_density(y, x) for y, x in zip(published[panel], cells, strict=True)])
            for panel, cells in measured.items()
        }
    )


@pytest.mark.parametrize("periods", [100, 500, 2000])
def test_the_true_reading_and_a_sensible_number_of_periods_are_recovered(periods: int):
    rng = np.random.default_rng(periods)
    readings = {
        "true": drawn(rng, {"light": 1, "heavy": 1}, 1500),
        "a twentieth more": drawn(rng, {"light": 1.05, "heavy": 1.05}, 1500),
        "light panel only": drawn(rng, {"light": 1, "heavy": 1.6}, 1500),
        "heavy panel only": drawn(rng, {"light": 1.3, "heavy": 1}, 1500),
    }
    source = drawn(rng, {"light": 1, "heavy": 1}, periods)
    published = {panel: [float(cell.mean()) for cell in cells] for panel, cells in source.items()}
    fits = {name: fitted(measured, published) for name, measured in readings.items()}
    assert max(fits, key=lambda name: fits[name].total) == "true"
    assert periods / 5 <= fits["true"].periods <= periods * 5
    # One panel alone does not save a reading, however well it fits there.
    for name, panel in (("light panel only", "light"), ("heavy panel only", "heavy")):
        assert fits[name].panels[panel] > fits["true"].panels[panel] - 5
        assert fits[name].total < fits["true"].total - 10


def test_the_total_is_the_sum_of_its_panels_at_one_number_of_periods():
    cells = {"a": np.array([[0.0, 3.0], [0.0, 1.0]]), "b": np.array([[2.5, -1.0]])}
    fit = joint_fit(cells, [100, 200])
    assert (fit.total, fit.panels, fit.periods) == (3.0, {"a": 4.0, "b": -1.0}, 200)
    assert fit.at == {100: 2.5, 200: 3.0}
    assert PERIODS[0] == 100
    assert PERIODS[-1] == 2000
