"""What runs differ in, and means over runs and their periods."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.measures import Recorded
from rl_design_space.analysis.statistics import Estimate, mean_estimate, percentile_interval, resample_weights
from rl_design_space.learning.result import FINAL_TRIALS

#: Every choice of a point by its name; one that an option does not have is not in it.
Parameters = Mapping[str, Any]

#: Of the periods of a run, one number each, whose mean is the scalar of that name.
PER_PERIOD: dict[str, Callable[[Recorded], FloatArray]] = {
    "total_steps": lambda recorded: recorded.steps.sum(axis=1, dtype=np.float64),
    "failed_trials": lambda recorded: 1 - np.asarray(recorded.success.mean(axis=1), np.float64),
    "failed_periods": lambda recorded: 1 - np.asarray(recorded.success.all(axis=1), np.float64),
    "final_steps_over_optimum": lambda recorded: np.asarray(
        recorded.over_optimum[:, -FINAL_TRIALS:].mean(axis=1), np.float64
    ),
}


def differing(points: Sequence[Parameters], beside: Collection[str] = ()) -> list[str]:
    """The parameters in which points differ.

    A value that an option alone decides is left out where the option itself differs: `reward.step` says nothing that
    `reward` does not say, as long as each reward has one `reward.step`.

    Args:
        points: by their parameters.
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
    """Mean over runs of the mean over their periods, with its 95 % bootstrap interval over periods.

    Args:
        runs: (periods,) of each.
        strata: of each run; those of one stratum met the same layouts, and their periods are resampled together.
    """
    if len(runs) == 1:
        return mean_estimate(runs[0])
    value = float(np.mean([run.mean() for run in runs]))
    if min(map(len, runs)) < 2:
        return Estimate(value, np.nan, np.nan)
    low, high = percentile_interval(resampled_means(runs, strata))
    return Estimate(value, float(low), float(high))


def resampled_means(runs: Sequence[FloatArray], strata: Sequence[Hashable]) -> FloatArray:
    """Bootstrap samples of the mean over runs of what they hold: (resamples, …) for runs of (periods, …)."""
    sums: dict[Hashable, FloatArray] = {}
    for run, stratum in zip(runs, strata, strict=True):
        sums[stratum] = sums[stratum] + run if stratum in sums else run
    parts = [resample_weights(len(total), seed) @ total for seed, total in enumerate(sums.values())]
    mean: FloatArray = np.sum(parts, axis=0) / len(runs)
    return mean
