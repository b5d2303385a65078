"""Shares of variance: against an independent calculation, known indices, noise, and the coverage of intervals."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from rl_design_space.analysis.importance import Cells, Decomposition, decomposed


def exact(means: np.ndarray) -> Decomposition:
    """Return the decomposition of means that are known exactly: two periods, both the same."""
    names = tuple(f"x{axis}" for axis in range(means.ndim))
    return decomposed([Cells.of_periods(names, np.stack([means, means]), resamples=10)])


def shares(found: Decomposition) -> dict[str, float]:
    return {each.effect: each.share.value for each in found.effects}


def totals(found: Decomposition) -> dict[str, float]:
    return {each.effect: each.total.value for each in found.effects if " × " not in each.effect}


def least_squares(means: np.ndarray) -> dict[str, float]:
    """Return shares by regression on dummy variables: what a model with an effect explains more than one without it."""
    columns = [np.indices(means.shape)[axis].ravel() for axis in range(means.ndim)]

    def explained(terms):
        design = [np.ones(means.size)]
        for term in terms:
            code = np.ravel_multi_index([columns[a] for a in term], [means.shape[a] for a in term])
            design += [code == level for level in np.unique(code)]
        matrix = np.array(design, dtype=float).T
        fitted = matrix @ np.linalg.lstsq(matrix, means.ravel(), rcond=None)[0]
        return float(((fitted - means.mean()) ** 2).sum() / ((means - means.mean()) ** 2).sum())

    axes = range(means.ndim)
    found = {f"x{a}": explained([(a,)]) for a in axes}
    found |= {
        f"x{a} × x{b}": explained([(a,), (b,), (a, b)]) - explained([(a,), (b,)]) for a, b in combinations(axes, 2)
    }
    return found


def test_shares_are_those_of_an_analysis_of_variance_by_regression():
    means = np.random.default_rng(3).normal(size=(3, 4, 2, 2)) + np.arange(3).reshape(3, 1, 1, 1)
    found = exact(means)
    assert shares(found) == pytest.approx(least_squares(means))
    assert found.variance.value == pytest.approx(means.var())
    assert sum(shares(found).values()) + found.rest.value == pytest.approx(1)
    without = means - means.mean(axis=1, keepdims=True)  # what remains when the other choices are known
    assert totals(found)["x1"] == pytest.approx((without**2).mean() / means.var())


def test_ishigami_has_its_known_sobol_indices():
    grid = (np.arange(60) + 0.5) / 60 * 2 * np.pi - np.pi
    x1, x2, x3 = np.meshgrid(grid, grid, grid, indexing="ij")
    found = exact(np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1))
    first = shares(found)
    assert [first[name] for name in ("x0", "x1", "x2")] == pytest.approx([0.3139, 0.4424, 0], abs=2e-3)
    assert first["x0 × x2"] == pytest.approx(0.2437, abs=2e-3)
    assert totals(found) == pytest.approx({"x0": 0.5576, "x1": 0.4424, "x2": 0.2437}, abs=2e-3)


def test_a_discrete_function_has_its_known_indices():
    """The function a + 2 b + a b c of independent signs: variances 1, 4 and 1."""
    a, b, c = np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij")
    found = exact((a + 2 * b + a * b * c).astype(float))
    known = {"x0": 1 / 6, "x1": 4 / 6, "x2": 0, "x0 × x1": 0, "x0 × x2": 0, "x1 × x2": 0}
    assert shares(found) == pytest.approx(known, abs=1e-12)
    assert totals(found) == pytest.approx({"x0": 2 / 6, "x1": 5 / 6, "x2": 1 / 6})
    assert found.rest.value == pytest.approx(1 / 6)
    assert found.effects[0].effect == "x1"


def test_noise_has_no_variance_on_average_and_says_that_it_is_noise():
    rng = np.random.default_rng(0)
    variances, noise = [], 0
    for _ in range(200):
        values = rng.normal(size=(30, 1, 1, 1)) + rng.standard_t(5, size=(30, 3, 2, 3))
        found = decomposed([Cells.of_periods(("a", "b", "c"), values, resamples=100)])
        variances.append([found.variance.value, *(each.share.value * found.variance.high for each in found.effects)])
        noise += found.is_noise
        if found.is_noise:
            assert sum(each.share.low <= 0 <= each.share.high for each in found.effects) >= 4
    plain = values.var(axis=0, ddof=1).mean() / 30  # what a plug-in estimate would call variance
    mean, error = np.mean(variances, axis=0), np.std(variances, axis=0) / np.sqrt(200)
    assert (np.abs(mean[0]) < 4 * error[0]).all()
    assert mean[0] < plain / 5
    assert noise >= 190


def test_intervals_hold_the_true_share_about_as_often_as_they_say():
    rng = np.random.default_rng(5)
    means = np.add.outer([0.0, 0.3, 0.6], [0.0, 0.5]) + np.array([[0, 0], [0.2, 0], [0, 0.2]])
    truth = {**shares(exact(means)), "total": totals(exact(means))["x0"]}
    held = dict.fromkeys(truth, 0)
    for _ in range(300):
        values = means + rng.normal(size=(60, 1, 1)) + rng.exponential(size=(60, 3, 2))
        found = decomposed([Cells.of_periods(("x0", "x1"), values, resamples=200)])
        for each in found.effects:
            held[each.effect] += each.share.low <= truth[each.effect] <= each.share.high
        total = next(each.total for each in found.effects if each.effect == "x0")
        held["total"] += total.low <= truth["total"] <= total.high
    assert all(0.90 <= count / 300 <= 0.99 for count in held.values()), held


def test_several_factorials_are_weighted_by_their_size():
    first = np.array([[0.0, 2.0], [0.0, 2.0], [0.0, 2.0]])  # only b matters, variance 1, 6 cells
    second = np.array([0.0, 4.0])  # only c matters, variance 4, 2 cells
    parts = [
        Cells.of_periods(names, np.stack([means, means]), resamples=10)
        for names, means in ((("a", "b"), first), (("c",), second))
    ]
    found = decomposed(parts)
    assert found.variance.value == pytest.approx((6 * 1 + 2 * 4) / 8)
    assert shares(found) == pytest.approx({"b": 6 / 14, "c": 8 / 14, "a": 0, "a × b": 0}, abs=1e-12)


def test_medians_are_freed_of_the_noise_that_their_resamples_show():
    rng = np.random.default_rng(2)
    values = rng.exponential(size=(200, 4, 3)) + np.arange(3) * 0.05
    samples = np.stack([np.median(values[rng.integers(0, 200, 200)], axis=0) for _ in range(300)])
    found = decomposed([Cells(("a", "b"), np.median(values, axis=0), samples)])
    plain = np.median(values, axis=0).var()
    assert found.variance.value < plain
    assert found.variance.low < (np.arange(3) * 0.05).var() < found.variance.high
