"""Measures at the best of several schedules, with the choice of the best as part of their uncertainty.

The periods are divided into halves at random, five times. Each half is judged at the schedule that is best on the
other half, and a period counts with a fifth at each of its five schedules: none judges a schedule that it has helped to
choose, so the value is not flattered, and all of them judge (repeated cross-fitting; Chernozhukov et al.,
"Double/debiased machine learning", Econometrics Journal 21, 2018). Resamples choose again: their spread is that of
choosing and judging.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, percentile_interval, resample_weights
from rl_design_space.learning.measure_statistics import Statistic
from rl_design_space.learning.measures import CurveMeasure, Measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.stage_record import combined

#: Fewer than for means, because medians of whole curves are resampled.
_RESAMPLES = 500
#: How often the periods are divided into halves.
_DIVISIONS = 5
#: Weights that are held in memory at once.
_AT_ONCE = 10_000_000


class Judged(NamedTuple):
    """A measure with its 95 % interval.

    Attributes:
        value: the number.
        low: lower end of the interval.
        high: upper end; infinite if samples of the measure are "never".
        never: whether the number itself stands for "never", which it is a lower bound of.
    """

    value: float
    low: float
    high: float
    never: bool = False


@dataclass(frozen=True)
class AtBest:
    """Measures at the best schedule.

    Attributes:
        best: name of the schedule that is best on all periods.
        exploration: sum of ε over the trials of that schedule; its interval is that of choosing again in resamples.
        measured: every other measure by name, at the schedules that the periods of other folds choose.
    """

    best: str
    exploration: Estimate
    measured: Mapping[str, Judged]


def at_best(schedules: Mapping[str, LearningCurves], best_by: Measure, measures: Mapping[str, Measure]) -> AtBest:
    """Return measures at the best of several schedules.

    Args:
        schedules: recorded points by name of their schedule, with the same layouts period by period.
        best_by: measure by which the best is chosen.
        measures: by name.
    """
    names, results = list(schedules), list(schedules.values())
    periods = len(results[0].steps)
    plain = np.full((1, periods), 1 / periods)
    weights = np.concatenate([plain, resample_weights(periods, resamples=_RESAMPLES)])
    halves = _halves(periods)
    chosen = [_best(results, best_by, _without(weights, half)) for half in halves]
    overall = _best(results, best_by, weights)
    exploration = np.array([result.epsilon.sum() for result in results])[overall]
    judges = _Judges(results, weights, halves, chosen)
    return AtBest(
        best=names[int(overall[0])],
        exploration=_estimate(exploration, periods),
        measured={name: judges.judge(measure) for name, measure in measures.items()},
    )


def _halves(periods: int) -> list[NDArray[np.bool_]]:
    """Return which periods are in each half of each division; the only period is in its half of all divisions."""
    rng = np.random.default_rng(0)
    firsts = [rng.permutation(periods) % 2 == 0 for _ in range(_DIVISIONS)]
    return [half for first in firsts for half in (first, ~first)]


def _without(weights: FloatArray, half: NDArray[np.bool_]) -> FloatArray:
    """Return weights of the periods outside of a half; unchanged where no other period has any weight."""
    outside = np.where(half, 0.0, weights)
    total = outside.sum(axis=1, keepdims=True)
    return np.where(total > 0, outside / np.where(total > 0, total, 1.0), weights)


def _best(results: Sequence[LearningCurves], best_by: Measure, weights: FloatArray) -> NDArray[np.intp]:
    """Return the place of the best schedule under each weighting of the periods."""
    sign = -1 if best_by.largest_is_best else 1
    values = np.array([sign * best_by.samples(result, weights) for result in results])
    best: NDArray[np.intp] = np.where(np.isnan(values), np.inf, values).argmin(axis=0)
    return best


class _Judges:
    """The periods of all schedules at which they are judged, in any resample.

    Args:
        results: of the schedules.
        weights: (resamples, periods), the first row without resampling.
        halves: (periods,) each, which periods are judged together.
        chosen: (resamples,) each, place of the schedule at which those periods are judged.
    """

    def __init__(
        self,
        results: Sequence[LearningCurves],
        weights: FloatArray,
        halves: Sequence[NDArray[np.bool_]],
        chosen: Sequence[NDArray[np.intp]],
    ) -> None:
        parts = []
        self._weights: list[FloatArray] = []
        for place in np.unique(chosen):
            times = sum(np.outer(best == place, half) for half, best in zip(halves, chosen, strict=True))
            of_place = weights * times / _DIVISIONS
            judging = of_place.any(axis=0)
            parts.append((results[place], judging))
            self._weights.append(of_place[:, judging])
        together: dict[str, Any] = {
            name: np.concatenate([getattr(result, name)[judging] for result, judging in parts])
            for name in ("steps", "success", "optimum")
        }
        first = results[0]
        stages = combined([result.of_periods(judging).stages for result, judging in parts])
        rows = np.zeros((len(together["steps"]), 2), dtype=np.int32)
        self._periods = LearningCurves(
            **together, rows=rows, epsilon=first.epsilon, known_point=first.known_point, stages=stages
        )
        self._count = weights.shape[1]
        self._known: dict[Statistic, FloatArray] = {}

    def judge(self, measure: Measure) -> Judged:
        """Return a measure with its interval.

        A share of periods has no narrower interval than Wilson's, and "never" has no upper end.
        """
        value, low, high = _estimate(self._samples(measure), self._count)
        each = measure.each(self._periods)
        if each is not None and np.isin(each, (0, 1)).all():
            least, most = _wilson(value, self._count)
            low, high = min(low, least), max(high, most)
        censored = measure.censored_at(self._periods)
        never = math.inf if censored is None else censored
        return Judged(value, low, math.inf if high >= never else high, value >= never)

    def _samples(self, measure: Measure) -> FloatArray:
        if isinstance(measure, CurveMeasure):
            return measure.of(self._curves(measure.statistic).copy())
        return np.concatenate([measure.samples(self._periods, block) for block in self._blocks()])

    def _curves(self, statistic: Statistic) -> FloatArray:
        """Return a statistic of each trial, (resamples, trials), which takes longer than most measures of it."""
        if statistic not in self._known:
            steps = self._periods.over_optimum
            self._known[statistic] = np.concatenate([statistic.of(steps, block) for block in self._blocks()])
        return self._known[statistic]

    def _blocks(self) -> Iterator[FloatArray]:
        rows = max(1, _AT_ONCE // len(self._periods.steps))
        starts = range(0, len(self._weights[0]), rows)
        return (np.concatenate([part[at : at + rows] for part in self._weights], axis=1) for at in starts)


def _estimate(samples: FloatArray, periods: int) -> Estimate:
    """Return the first of the samples with the interval of the others; without one if there is a single period."""
    if periods < 2:
        return Estimate(float(samples[0]), np.nan, np.nan)
    low, high = percentile_interval(samples[1:])
    return Estimate(float(samples[0]), float(low), float(high))


def _wilson(share: float, periods: int) -> tuple[float, float]:
    """Return Wilson's interval of a share, which need not be a whole number of periods (JASA 22, 1927)."""
    z2 = 1.959964**2
    middle = share + z2 / (2 * periods)
    reach = math.sqrt(z2 * (share * (1 - share) / periods + z2 / (4 * periods**2)))
    return (middle - reach) / (1 + z2 / periods), (middle + reach) / (1 + z2 / periods)
