"""The set of the best: how often it holds the true best, ties, a single design, heavy tails."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis import best
from rl_design_space.analysis.best import BestSet, best_set
from rl_design_space.analysis.statistics import resample_weights

RESAMPLES = 300


def found(each: np.ndarray, **options) -> BestSet:
    samples = resample_weights(len(each), 0, RESAMPLES) @ each
    return best_set(each.mean(axis=0), samples, each, periods=len(each), **options)


def normal(rng: np.random.Generator, size) -> np.ndarray:
    return rng.normal(size=size)


def heavy(rng: np.random.Generator, size) -> np.ndarray:
    """One period in twenty takes most of the steps."""
    return np.where(rng.random(size) < 0.05, rng.exponential(8, size), rng.exponential(0.6, size)) - 0.97


def partly_heavy(rng: np.random.Generator, size) -> np.ndarray:
    """The first design, which is the best, has no heavy tail; all others have one."""
    return np.hstack([rng.normal(size=(size[0], 1)), heavy(rng, (size[0], size[1] - 1))])


@pytest.fixture(autouse=True)
def few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(best, "RESAMPLES", RESAMPLES)


@pytest.mark.parametrize(("draw", "periods"), [(normal, 120), (heavy, 120), (partly_heavy, 500)])
def test_the_true_best_is_in_the_set_and_losses_are_bounded_in_95_of_100_cases(draw, periods: int):
    rng = np.random.default_rng(7)
    means = np.array([0.0, 0.0, 0.0, 0.1, 0.4])  # three that are best
    held = bounded = 0
    for _ in range(200):
        each = means + rng.normal(size=(periods, 1)) + draw(rng, (periods, 5))
        result = found(each)
        held += int(result.inside[0])
        bounded += bool((result.loss_at_most >= means).all())
    assert held / 200 >= 0.93
    assert bounded / 200 >= 0.93


def test_a_clearly_worse_design_is_left_out_and_a_near_one_needs_more_periods():
    rng = np.random.default_rng(1)
    each = rng.normal(size=(100, 1)) * 5 + rng.normal(size=(100, 3)) + [0, 0.35, 2]
    result = found(each)
    assert result.leader == 0
    assert result.inside.tolist() == [True, True, False]
    assert 2 < result.loss_at_most[2] < 3
    assert result.loss_at_most[0] < result.loss_at_most[1] < 1
    assert result.probability.sum() == pytest.approx(1)
    assert result.periods[1] > 100
    assert np.isnan(result.periods[[0, 2]]).all()
    upside_down = found(-each, largest_is_best=True)
    assert upside_down.inside.tolist() == result.inside.tolist()
    assert upside_down.loss_at_most == pytest.approx(result.loss_at_most)


def test_the_periods_that_would_decide_do_decide_mostly():
    rng = np.random.default_rng(3)
    difference, error = 0.2, np.sqrt(2)
    each = rng.normal(size=(100, 2))
    each = (each - each.mean(axis=0)) / (each[:, 1] - each[:, 0]).std(ddof=1) * error + [0, difference]
    needed = int(found(each).periods[1])
    decided = [not found(rng.normal(size=(needed, 2)) + np.array([0, difference])).inside[1] for _ in range(100)]
    assert 0.65 <= np.mean(decided) <= 0.95


def test_equal_designs_are_in_the_set_together():
    one = np.random.default_rng(0).exponential(size=(50, 1))
    result = found(np.hstack([one, one + 1, one]))
    assert result.inside.tolist() == [True, False, True]
    assert result.loss_at_most == pytest.approx([0, 1, 0])
    assert result.probability == pytest.approx([0.5, 0, 0.5])
    assert np.isinf(result.periods[2])


def test_the_only_design_of_the_set_has_nothing_to_be_decided():
    each = np.random.default_rng(6).normal(size=(60, 2)) + np.array([2, 0])
    each[30:, 1] = np.nan  # the worse design has more periods
    result = found(each)
    assert (result.leader, result.inside.tolist()) == (0, [False, True])
    assert np.isnan(result.periods).all()


def test_a_single_design_is_the_best():
    result = found(np.arange(10.0)[:, np.newaxis])
    assert (result.inside.tolist(), result.loss_at_most.tolist(), result.probability.tolist()) == ([True], [0], [1])


def test_medians_are_compared_by_their_resamples():
    rng = np.random.default_rng(4)
    held = 0
    for _ in range(50):
        each = rng.normal(size=(80, 1)) + heavy(rng, (80, 4))
        drawn = np.array([np.median(each[rng.integers(0, 80, 80)], axis=0) for _ in range(100)])
        result = best_set(np.median(each, axis=0), drawn, periods=80)
        held += int(result.inside[0])
    assert held >= 45


def test_many_designs_share_the_work():
    rng = np.random.default_rng(5)
    each = rng.normal(size=(20, 400)) + np.linspace(0, 3, 400)
    result = found(each)
    assert result.inside[:10].sum() >= 8
    assert not result.inside[-80:].any()
