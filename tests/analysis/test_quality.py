"""Quality of a representation: selected on one half of the periods, judged on the other."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.analysis.quality import quality
from tests.analysis.made_up import MadeUp


def test_the_best_schedule_is_selected():
    fast = MadeUp(until=4, last=12.0, noise=0.0, exploration=3.0)
    found = quality({"slow": MadeUp(until=12, exploration=9.0), "fast": fast})
    assert found.best == "fast"
    assert found.speed == (4, 4, 4)
    assert found.over_optimum.value == pytest.approx(1.2)
    assert found.never_near.value == 1
    assert found.exploration == pytest.approx((3.0, 3.0, 3.0))


def test_an_uncertain_selection_widens_the_interval():
    one, other = MadeUp(until=6, noise=0.9, exploration=1.0), MadeUp(until=6, noise=0.9001, exploration=5.0)
    steps = other.steps

    class Shuffled(MadeUp):
        @property
        def steps(self):
            return np.random.default_rng(2).permutation(steps)

    found = quality({"one": one, "other": Shuffled(exploration=5.0)})
    assert (found.exploration.low, found.exploration.high) == pytest.approx((1.0, 5.0))


def test_the_half_that_selects_does_not_judge():
    class Lucky(MadeUp):
        @property
        def steps(self):
            steps = super().steps.copy()
            steps[0::2] //= 5
            steps[1::2] *= 5
            return steps

    found = quality({"lucky": Lucky(noise=0.0), "plain": MadeUp(noise=0.0)})
    assert found.best == "lucky"
    assert found.over_optimum.value == pytest.approx(5)


def test_a_share_has_a_wilson_interval():
    found = quality({"near": MadeUp(noise=0.0)})
    assert found.never_near.value == 0
    assert found.never_near.low == pytest.approx(0)
    # z² / (n + z²) for 30 periods.
    assert found.never_near.high == pytest.approx(1.96**2 / (30 + 1.96**2), abs=1e-3)


def test_one_period_is_enough():
    found = quality({"only": MadeUp(periods=1)})
    assert found.best == "only"
    assert np.isnan(found.over_optimum.low)
