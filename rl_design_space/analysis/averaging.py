"""Means over designs, each over the periods of all its seeds, with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.pooling import Pool, Repetition
from rl_design_space.analysis.statistics import Estimate, mean_estimate, percentile_interval
from rl_design_space.learning.measures import Measure
from rl_design_space.learning.result import LearningCurves


def mean_of_runs(runs: Sequence[FloatArray], repetitions: Sequence[Repetition]) -> Estimate:
    """Return the mean over designs of the mean over their periods, with its 95 % bootstrap interval.

    Args:
        runs: (periods,) values of each run.
        repetitions: where the periods of each run come from.
    """
    pool = Pool(repetitions, [len(run) for run in runs])
    designs = [pool.pooled(design, runs) for design in range(len(pool.designs))]
    if pool.is_one_sample:
        return mean_estimate(designs[0])
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


def estimate(measured: Measure, runs: Sequence[LearningCurves], repetitions: Sequence[Repetition]) -> Estimate:
    """Return the mean over designs of a measure of their periods, with its 95 % bootstrap interval.

    Args:
        measured: the measure.
        runs: results of the runs.
        repetitions: where the periods of each run come from.
    """
    each = [values for run in runs if (values := measured.each(run)) is not None]
    if each:
        return mean_of_runs(each, repetitions)
    pool = Pool(repetitions, [len(run.steps) for run in runs])
    designs = [_pooled(pool, design, runs) for design in range(len(pool.designs))]
    value = np.mean([measured.samples(result, _equal(len(result.steps))) for result in designs])
    if not pool.can_be_resampled:
        return Estimate(float(value), np.nan, np.nan)
    samples = [
        np.mean([measured.samples(result, of) for result, of in zip(designs, weights, strict=True)], axis=0)
        for weights in pool.weights()
    ]
    low, high = percentile_interval(np.concatenate(samples))
    return Estimate(float(value), float(low), float(high))


def pooled(runs: Sequence[LearningCurves]) -> LearningCurves:
    """Return the periods of several seeds of one design as one result."""
    if len(runs) == 1:
        return runs[0]
    together: dict[str, Any] = {name: np.concatenate([getattr(run, name) for run in runs]) for name in _OF_PERIODS}
    return replace(runs[0], **together, seconds=sum(run.seconds for run in runs))


#: Arrays of a result that have a row for each period.
_OF_PERIODS = ("steps", "success", "optimum", "rows")


def _pooled(pool: Pool, design: int, runs: Sequence[LearningCurves]) -> LearningCurves:
    """Return the result of a design, its periods in the order in which they are resampled."""
    together: dict[str, Any] = {name: pool.pooled(design, [getattr(run, name) for run in runs]) for name in _OF_PERIODS}
    return replace(runs[pool.designs[design][0]], **together)


def _with_interval(value: float, pool: Pool, runs: Sequence[FloatArray]) -> Estimate:
    if not pool.can_be_resampled:
        return Estimate(value, np.nan, np.nan)
    low, high = percentile_interval(pool.resampled_means(runs))
    return Estimate(value, float(low), float(high))


def _equal(periods: int) -> FloatArray:
    return np.full((1, periods), 1 / periods)
