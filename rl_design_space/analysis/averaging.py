"""Means over designs, each over the periods of all its seeds, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.censoring import Bounded, Censored
from rl_design_space.analysis.pooling import Pool, Repetition
from rl_design_space.analysis.statistics import Estimate, mean_estimate, mean_share_estimate, percentile_interval
from rl_design_space.learning.measures import Measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.stage_record import combined


def mean_of_runs(runs: Sequence[FloatArray], repetitions: Sequence[Repetition], *, of_shares: bool = False) -> Estimate:
    """Return the mean over designs of the mean over their periods, with its 95 % interval.

    Args:
        runs: (periods,) values of each run.
        repetitions: where the periods of each run come from.
        of_shares: whether the values are shares, see `mean_share_estimate`.
    """
    pool = Pool(repetitions, [len(run) for run in runs])
    designs = [pool.pooled(design, runs) for design in range(len(pool.designs))]
    if pool.is_one_sample:
        return (mean_share_estimate if of_shares else mean_estimate)(designs[0])
    if of_shares and len(known := np.unique(np.concatenate(designs))) == 1 and known[0] in (0, 1):
        return mean_share_estimate(min(designs, key=len))  # which tells least
    return _with_interval(float(np.mean([values.mean() for values in designs])), pool, runs)


def curve_of_runs(runs: Sequence[FloatArray], repetitions: Sequence[Repetition]) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the 95 % bootstrap interval of the mean over designs, (trials,) each; NaN if it is not known.

    Args:
        runs: (periods, trials) values of each run.
        repetitions: where the periods of each run come from.
    """
    pool = Pool(repetitions, [len(run) for run in runs])
    if not pool.can_be_resampled:
        nothing = np.full(runs[0].shape[1], np.nan)
        return nothing, nothing
    return percentile_interval(pool.resampled_means(runs))


def estimate(measured: Measure, runs: Sequence[LearningCurves], repetitions: Sequence[Repetition]) -> Bounded:
    """Return the mean over designs of a measure of their periods, with its 95 % bootstrap interval.

    Args:
        measured: the measure.
        runs: results of the runs.
        repetitions: where the periods of each run come from.
    """
    each = [values for run in runs if (values := measured.each(run)) is not None]
    if each:
        return Bounded(*mean_of_runs(each, repetitions, of_shares=measured.is_share))
    return _resampled([[(1, run)] for run in runs], measured, repetitions)


def estimate_difference(
    measured: Measure,
    before: Sequence[Sequence[LearningCurves]],
    after: Sequence[Sequence[LearningCurves]],
    repetitions: Sequence[Repetition],
) -> Bounded:
    """Return the mean over pairs of designs of the difference of a measure, after minus before.

    Both sides are resampled with the same weights, period by period.

    Args:
        measured: the measure.
        before: results of one side of each pair, whose mean counts; all of a pair have equally many periods.
        after: results of the other side.
        repetitions: where the periods of each pair come from.
    """
    sides = [
        [(weight / len(side), run) for weight, side in ((-1, one), (1, other)) for run in side]
        for one, other in zip(before, after, strict=True)
    ]
    return _resampled(sides, measured, repetitions)


def value_of_sides(
    measured: Measure, sides: Sequence[Sequence[LearningCurves]], repetitions: Sequence[Repetition]
) -> Bounded:
    """Return the mean over pairs of designs of a measure of one side, without interval, see `estimate_difference`."""
    pool = Pool(repetitions, [len(side[0].steps) for side in sides])
    terms = [[(1 / len(side), run) for run in side] for side in sides]
    return Bounded.of(_value(measured, _pooled_designs(pool, terms)), None)


#: Terms of a sum of measures of results with the same layouts: a factor and the result.
_Terms = Sequence[tuple[float, LearningCurves]]


def _resampled(terms: Sequence[_Terms], measured: Measure, repetitions: Sequence[Repetition]) -> Bounded:
    """Return the mean over designs of sums of a measure, with its interval.

    Args:
        terms: what is summed up, for each run; those of one design have the same factors.
        measured: the measure.
        repetitions: where the periods of each run come from.
    """
    pool = Pool(repetitions, [len(run[0][1].steps) for run in terms])
    designs = _pooled_designs(pool, terms)
    value = _value(measured, designs)
    if not pool.can_be_resampled:
        return Bounded.of(value, None)
    return Bounded.of(value, Censored.joined([_mean(measured, designs, weights) for weights in pool.weights()]))


def _pooled_designs(pool: Pool, terms: Sequence[_Terms]) -> list[_Terms]:
    return [_pooled_terms(pool, design, terms) for design in range(len(pool.designs))]


def _value(measured: Measure, designs: Sequence[_Terms]) -> Censored:
    return _mean(measured, designs, [_equal(len(design[0][1].steps)) for design in designs])


def _mean(measured: Measure, designs: Sequence[_Terms], weights: Sequence[FloatArray]) -> Censored:
    """Return the mean over designs of their sums, under each weighting of the periods of each."""
    sums = []
    for terms, of_design in zip(designs, weights, strict=True):
        (factor, first), *others = terms
        total = Censored.of(measured, first, of_design).times(factor)
        for factor, result in others:
            total += Censored.of(measured, result, of_design).times(factor)
        sums.append(total)
    return Censored.mean(sums)


def _pooled_terms(pool: Pool, design: int, terms: Sequence[_Terms]) -> _Terms:
    """Return the terms of a design, each with the periods of all its runs."""
    factors = [factor for factor, _ in terms[pool.designs[design][0]]]
    # Runs of other designs, which may have fewer terms, are only there to be counted.
    runs = [[run[min(place, len(run) - 1)][1] for run in terms] for place in range(len(factors))]
    return [(factor, _pooled(pool, design, each)) for factor, each in zip(factors, runs, strict=True)]


def pooled(runs: Sequence[LearningCurves]) -> LearningCurves:
    """Return the periods of several seeds of one design as one result."""
    if len(runs) == 1:
        return runs[0]
    together: dict[str, Any] = {name: np.concatenate([getattr(run, name) for run in runs]) for name in _OF_PERIODS}
    stages = combined([run.stages for run in runs])
    return replace(runs[0], **together, stages=stages, seconds=sum(run.seconds for run in runs))


#: Arrays of a result that have a row for each period.
_OF_PERIODS = ("steps", "success", "optimum", "rows")


def _pooled(pool: Pool, design: int, runs: Sequence[LearningCurves]) -> LearningCurves:
    """Return the result of a design, its periods in the order in which they are resampled."""
    together: dict[str, Any] = {name: pool.pooled(design, [getattr(run, name) for run in runs]) for name in _OF_PERIODS}
    stages = combined([run.stages for run in runs], lambda arrays: pool.pooled(design, arrays))
    return replace(runs[pool.designs[design][0]], **together, stages=stages)


def _with_interval(value: float, pool: Pool, runs: Sequence[FloatArray]) -> Estimate:
    if not pool.can_be_resampled:
        return Estimate(value, np.nan, np.nan)
    low, high = percentile_interval(pool.resampled_means(runs))
    return Estimate(value, float(low), float(high))


def _equal(periods: int) -> FloatArray:
    return np.full((1, periods), 1 / periods)
