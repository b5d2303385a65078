"""A race: looks and their errors, who stops, who goes on again, and how often the true best is lost."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis import best
from rl_design_space.analysis.best import best_means
from rl_design_space.analysis.race import Look, behind, looks, matrix


def raced(each: np.ndarray, at: tuple[Look, ...]) -> np.ndarray:
    """Return the number of periods that each design gets, of (periods, designs) numbers."""
    counts = np.full(each.shape[1], at[0].periods)
    for look, following in zip(at, [*at[1:], at[-1]], strict=True):
        while True:
            worse = behind([each[:count, design] for design, count in enumerate(counts)], look)
            if not (again := ~worse & (counts < look.periods)).any():
                break
            counts[again] = look.periods
        counts[~worse] = following.periods
    return counts


def test_looks_share_the_error_and_the_last_has_nine_tenths():
    found = looks(300)
    assert [look.periods for look in found] == [20, 30, 45, 68, 102, 153, 230, 300]
    assert sum(look.error for look in found) == pytest.approx(0.05)
    assert found[-1].error == pytest.approx(0.045)
    assert looks(500, first=50, growth=2)[-1].periods == 500
    assert looks(15) == (Look(15, pytest.approx(0.05)),)
    for most in range(5, 200, 7):
        counts = [look.periods for look in looks(most, 5, 1.1)]
        assert counts == sorted(set(counts))
        assert counts[-1] == most


def test_a_design_stops_once_another_is_better_beyond_doubt():
    rng = np.random.default_rng(0)
    each = rng.normal(size=(300, 1)) * 5 + rng.normal(size=(300, 4)) + [0, 0.1, 1, 3]
    counts = raced(each, looks(300))
    assert counts[3] <= 30 < counts[2] < 300
    assert counts[:2].tolist() == [300, 300]


def test_the_numbers_after_a_look_do_not_matter_and_neither_does_the_order():
    rng = np.random.default_rng(1)
    each = rng.exponential(size=(60, 30)) * np.linspace(1, 4, 30)
    look = looks(60)[1]
    values = [each[: look.periods, design] for design in range(30)]
    found = behind(values, look)
    assert behind([each[:, design] for design in range(30)], look)[found].all()
    order = rng.permutation(30)
    assert (behind([values[design] for design in order], look) == found[order]).all()
    assert (behind([10 * value + 3 for value in values], look) == found).all()


def test_a_stopped_design_goes_on_when_its_rival_turns_out_to_have_a_heavy_tail():
    rng = np.random.default_rng(2)
    stopped, rival = rng.normal(10, 1, 20), rng.normal(8, 1, 45)
    look = Look(45, 0.001)
    assert behind([stopped, rival], look).tolist() == [True, False]
    rival[[25, 33, 40]] = 400
    assert behind([stopped, rival], look).tolist() == [False, False]


def test_far_outliers_do_not_keep_a_worse_design_in_the_race():
    rng = np.random.default_rng(3)
    best, worse = rng.normal(10, 1, 50), rng.normal(14, 1, 50)
    worse[[7, 30]] = 5000
    assert behind([best, worse], Look(50, 0.001)).tolist() == [False, True]
    assert best_means(matrix([best, worse])).inside.tolist() == [True, False]


def test_equal_designs_go_on_together():
    one = np.random.default_rng(4).exponential(size=30)
    assert not behind([one, one, one[:30]], Look(30, 0.01)).any()
    assert not behind([np.ones(10), np.ones(10)], Look(10, 0.01)).any()


def test_the_final_set_compares_each_two_over_the_periods_that_both_have():
    rng = np.random.default_rng(5)
    each = rng.normal(size=(200, 1)) * 3 + rng.normal(size=(200, 6)) + [0, 0.05, 2, 2.5, 3, 4]
    counts = [200, 200, 30, 30, 20, 20]
    found = best_means(matrix([each[:count, design] for design, count in enumerate(counts)]))
    assert found.inside.tolist() == [True, True, False, False, False, False]
    assert found.probability.sum() == pytest.approx(1)
    assert not found.probability[2:].any()
    # Over its own 20 periods, which were easy ones, a design may look better than those that took 200.
    easy = np.argsort(each.mean(axis=1))
    found = best_means(matrix([each[easy][:count, design] for design, count in enumerate(counts)]))
    assert not found.inside[2:].any()
    assert (found.loss_at_most[:2] < 1).all()


@pytest.mark.parametrize("tail", [0, 2], ids=["normal", "skewed"])
def test_the_true_best_is_lost_in_5_of_100_races_at_most(tail: float, monkeypatch: pytest.MonkeyPatch):
    """Five designs are the best, so each of them should be in 95 of 100 sets; however often one looks."""
    monkeypatch.setattr(best, "RESAMPLES", 150)
    rng = np.random.default_rng(6)
    means = np.r_[np.zeros(5), np.linspace(0.3, 3, 10)]
    at, races = looks(80), 25
    lost = stopped = steps = 0.0
    for _ in range(races):
        noise = rng.normal(size=(80, 15)) if not tail else rng.lognormal(0, 1, (80, 15)) / 2.16
        each = means + rng.normal(size=(80, 1)) + noise
        counts = raced(each, at)
        stopped += (counts[:5] < 80).mean()
        lost += (~best_means(matrix([each[:n, i] for i, n in enumerate(counts)])).inside[:5]).mean()
        steps += counts.mean() / 80
    assert lost / races <= 0.05
    assert stopped / races <= 0.01
    assert steps / races < 0.8
