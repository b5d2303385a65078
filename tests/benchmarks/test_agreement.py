"""Agreement is judged in pairs of equal layouts, strictly but not at random."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.agreement import compare
from benchmarks.peers import OURS


def drawn(rng: np.random.Generator, periods: int, factor: float = 1.0) -> np.ndarray:
    """Total steps as they are spread in the job, half of it by the layout."""
    layouts = np.random.default_rng(0).normal(9000, 1500, periods)
    return np.rint(factor * (layouts + rng.normal(0, 900, periods))).astype(np.int64)


def test_equal_jobs_agree():
    rng = np.random.default_rng(1)
    for _ in range(200):
        agreement = compare({OURS: {0: drawn(rng, 500)}, "peer": {0: drawn(rng, 20)}})["peer"]
        assert agreement.agrees
        assert agreement.periods == 20


@pytest.mark.parametrize(("factor", "periods"), [(0.8, 20), (1.05, 500), (0.97, 1000)])
def test_another_job_is_found(factor: float, periods: int):
    rng = np.random.default_rng(2)
    agreement = compare({OURS: {0: drawn(rng, periods)}, "peer": {0: drawn(rng, periods, factor)}})["peer"]
    assert not agreement.agrees
    assert np.sign(agreement.difference) == np.sign(factor - 1)
    assert abs(agreement.difference) > agreement.detectable


def test_the_same_steps_agree_and_a_constant_offset_does_not():
    steps = drawn(np.random.default_rng(3), 50)
    verdicts = compare({OURS: {0: steps}, "same": {0: steps}, "offset": {0: steps + 1}})
    assert (verdicts[OURS].t, verdicts["same"].t) == (0.0, 0.0)
    assert verdicts["same"].agrees
    assert not verdicts["offset"].agrees


def test_only_common_layouts_are_compared():
    steps = np.array([10, 20, 30])
    verdict = compare({OURS: {0: steps, 1: steps}, "peer": {1: steps[:2], 2: steps + 100}})["peer"]
    assert (verdict.periods, verdict.mean, verdict.t) == (2, 15.0, 0.0)


def test_one_period_is_nothing_to_judge_by():
    with pytest.raises(ValueError, match="peer: fewer than two periods"):
        compare({OURS: {0: np.array([1, 2])}, "peer": {0: np.array([1])}})
