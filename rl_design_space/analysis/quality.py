"""Quality of a representation at its best schedule: speed, final policy, and exploration (Table 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, mean_estimate, percentile_interval, share_estimate
from rl_design_space.learning.measure_statistics import MEDIAN
from rl_design_space.learning.measures import FINAL_TRIALS, NEAR, converged
from rl_design_space.learning.result import LearningCurves

#: Number of resamples.
_RESAMPLES = 2000


@dataclass(frozen=True)
class Quality:
    """Quality at the best schedule, which is selected on the even-numbered periods and judged on the odd-numbered ones.

    Attributes:
        best: name of the selected schedule.
        speed: trials until the median over periods has converged to within 10 % of its final level.
        over_optimum: steps / optimum in the last trials.
        never_near: share of periods whose last trials need more than 1.1 times the optimum.
        exploration: sum of ε over the trials of the selected schedule; its interval is that of selecting in resamples.
    """

    best: str
    speed: Estimate
    over_optimum: Estimate
    never_near: Estimate
    exploration: Estimate


def quality(schedules: Mapping[str, LearningCurves]) -> Quality:
    """Return the quality of a representation, from points with different schedules.

    Args:
        schedules: recorded points by name of their schedule; the one with the fewest total steps is the best.
    """
    totals = np.array([recorded.total_steps for recorded in schedules.values()])
    exploration = np.array([recorded.epsilon.sum() for recorded in schedules.values()])
    chosen = int(totals[:, 0::2].mean(axis=1).argmin())
    name, recorded = list(schedules.items())[chosen]
    rng = np.random.default_rng(0)
    periods = totals.shape[1]
    weights = rng.multinomial(periods, np.full(periods, 1 / periods), size=_RESAMPLES) / periods
    again = exploration[(weights @ totals.T).argmin(axis=1)]
    odd = slice(1, None, 2) if periods > 1 else slice(None)
    final = recorded.over_optimum[odd, -FINAL_TRIALS:].mean(axis=1)
    return Quality(
        best=name,
        speed=_speed(recorded.steps[odd], rng),
        over_optimum=mean_estimate(final),
        never_near=share_estimate(final > NEAR),
        exploration=_estimate(float(exploration[chosen]), again),
    )


def _speed(steps: NDArray[Any], rng: np.random.Generator) -> Estimate:
    periods = len(steps)
    drawn = rng.integers(periods, size=(_RESAMPLES, periods))
    times = np.array([np.bincount(picked, minlength=periods) for picked in drawn])
    medians = MEDIAN.of(steps, times / periods)
    return _estimate(float(_converged(np.median(steps, axis=0))), _converged(medians))


def _converged(curves: FloatArray) -> FloatArray:
    """Return the first trial from which on each curve, (..., trials), stays near its final level."""
    return converged(curves, np.median(curves[..., -FINAL_TRIALS:], axis=-1, keepdims=True))


def _estimate(value: float, samples: FloatArray) -> Estimate:
    low, high = percentile_interval(samples)
    return Estimate(value, float(low), float(high))
