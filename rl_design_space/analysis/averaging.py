"""Parameters in which runs differ, and means over runs and their periods."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, mean_estimate, percentile_interval, resample_weights
from rl_design_space.learning.measures import Measure
from rl_design_space.learning.result import LearningCurves

#: Every choice of a point by its name; choices that its options do not have are missing.
Parameters = Mapping[str, Any]


def differing(points: Sequence[Parameters], beside: Collection[str] = ()) -> list[str]:
    """Return the parameters in which points differ.

    A value that follows from an option is left out if the option itself differs: `reward.step` adds nothing to `reward`
    if each reward has one `reward.step`.

    Args:
        points: parameters of each point.
        beside: parameters that are known to differ.
    """
    names = dict.fromkeys(name for point in points for name in point)
    vary = [name for name in names if len({point.get(name) for point in points}) > 1]
    return [name for name in vary if name not in beside and not _decided_by_option(name, points, {*vary, *beside})]


def _decided_by_option(name: str, points: Iterable[Parameters], vary: Collection[str]) -> bool:
    option, dot, _ = name.partition(".")
    if not dot or option not in vary:
        return False
    values: dict[Any, set[Any]] = {}
    for point in points:
        values.setdefault(point.get(option), set()).add(point.get(name))
    return all(len(each) == 1 for each in values.values())


def mean_of_runs(runs: Sequence[FloatArray], strata: Sequence[Hashable]) -> Estimate:
    """Return the mean over runs of the mean over their periods, with its 95 % bootstrap interval over periods.

    Args:
        runs: (periods,) values of each run.
        strata: stratum of each run; runs of one stratum have the same layouts, so their periods are resampled together.
    """
    if len(runs) == 1:
        return mean_estimate(runs[0])
    value = float(np.mean([run.mean() for run in runs]))
    if min(map(len, runs)) < 2:
        return Estimate(value, np.nan, np.nan)
    low, high = percentile_interval(resampled_means(runs, strata))
    return Estimate(value, float(low), float(high))


def resampled_means(runs: Sequence[FloatArray], strata: Sequence[Hashable]) -> FloatArray:
    """Return bootstrap samples of the mean over runs: (resamples, …) for runs of (periods, …)."""
    sums: dict[Hashable, FloatArray] = {}
    for run, stratum in zip(runs, strata, strict=True):
        sums[stratum] = sums[stratum] + run if stratum in sums else run
    parts = [resample_weights(len(total), seed) @ total for seed, total in enumerate(sums.values())]
    mean: FloatArray = np.sum(parts, axis=0) / len(runs)
    return mean


def estimate(measured: Measure, runs: Sequence[LearningCurves], strata: Sequence[Hashable]) -> Estimate:
    """Return the mean of a measure over runs, with its 95 % bootstrap interval over periods.

    Args:
        measured: the measure.
        runs: results of the runs.
        strata: stratum of each run; runs of one stratum have the same layouts, so their periods are resampled together.
    """
    each = [values for run in runs if (values := measured.each(run)) is not None]
    if each:
        return mean_of_runs(each, strata)
    seeds = {stratum: seed for seed, stratum in enumerate(dict.fromkeys(strata))}
    value = np.mean([measured.samples(run, np.full((1, len(run.steps)), 1 / len(run.steps))) for run in runs])
    if min(len(run.steps) for run in runs) < 2:
        return Estimate(float(value), np.nan, np.nan)
    resampled = [
        measured.samples(run, resample_weights(len(run.steps), seeds[stratum]))
        for run, stratum in zip(runs, strata, strict=True)
    ]
    low, high = percentile_interval(np.mean(resampled, axis=0))
    return Estimate(float(value), float(low), float(high))
