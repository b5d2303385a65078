"""Measures: what is read off the periods of a point, each with its bootstrap samples over periods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.result import FINAL_TRIALS

#: A policy is near its final level, or near the optimum, within this factor.
NEAR = 1.1
#: A trial that takes so many times the fewest moves possible is an outlier.
OUTLIER = 10


class Recorded(Protocol):
    """What was recorded of a point, see `report.runs.Periods`."""

    @property
    def steps(self) -> NDArray[np.integer]:
        """(periods, trials) primitive moves."""
        ...

    @property
    def success(self) -> NDArray[np.bool_]:
        """(periods, trials) whether the final goal was reached."""
        ...

    @property
    def over_optimum(self) -> FloatArray:
        """(periods, trials) steps / optimum."""
        ...

    @property
    def epsilon(self) -> FloatArray:
        """(trials,) the exploration schedule."""
        ...


#: Of the periods of a point, one number each: their mean is the measure.
PER_PERIOD: dict[str, Callable[[Recorded], FloatArray]] = {
    "total_steps": lambda recorded: recorded.steps.sum(axis=1, dtype=np.float64),
    "late_steps": lambda recorded: recorded.steps[:, recorded.steps.shape[1] // 2 :].mean(axis=1),
    "final_over_optimum": lambda recorded: recorded.over_optimum[:, -FINAL_TRIALS:].mean(axis=1),
    "final_failed": lambda recorded: (~recorded.success[:, -FINAL_TRIALS:]).mean(axis=1),
    "not_near_optimum": lambda recorded: (recorded.over_optimum[:, -FINAL_TRIALS:].mean(axis=1) > NEAR).astype(float),
    "outliers": lambda recorded: (recorded.over_optimum > OUTLIER)[:, recorded.steps.shape[1] // 2 :].mean(axis=1),
}
#: Of the mean learning curve (over periods) of steps / optimum; curves are (..., trials), results (...,).
OF_CURVE: dict[str, Callable[[FloatArray], FloatArray]] = {
    "trials_to_final": lambda curves: _settled(curves, curves[..., -FINAL_TRIALS:].mean(axis=-1, keepdims=True)),
    "trials_to_optimum": lambda curves: _settled(curves, np.ones_like(curves[..., :1])),
    "roughness": lambda curves: np.abs(np.diff(np.log(curves), n=2, axis=-1)).mean(axis=-1),
}
#: What each measure is, for people.
MEANINGS = {
    "total_steps": "primitive moves of all trials of a period, mean over periods",
    "late_steps": "primitive moves a trial in the second half of the trials",
    "final_over_optimum": f"steps / optimum in the last {FINAL_TRIALS} trials",
    "final_failed": f"share of the last {FINAL_TRIALS} trials that miss the final goal",
    "not_near_optimum": f"share of periods whose last {FINAL_TRIALS} trials need more than {NEAR} times the optimum",
    "outliers": f"share of trials in the second half that need more than {OUTLIER} times the optimum",
    "trials_to_final": f"trials until the mean curve of steps / optimum stays within {NEAR} times its final level",
    "trials_to_optimum": f"trials until the mean curve of steps / optimum stays within {NEAR}",
    "roughness": "mean absolute second difference of the logarithm of the mean curve",
}


def measure(name: str, recorded: Recorded, weights: FloatArray) -> FloatArray:
    """A measure of a point under each weighting of its periods.

    Args:
        name: of `PER_PERIOD` or `OF_CURVE`.
        recorded: of the point.
        weights: (resamples, periods), see `statistics.resample_weights`; equal weights give the plain value.

    Returns:
        (resamples,)
    """
    if name in PER_PERIOD:
        values: FloatArray = weights @ PER_PERIOD[name](recorded)
        return values
    return OF_CURVE[name](weights @ recorded.over_optimum)


def _settled(curves: FloatArray, level: FloatArray) -> FloatArray:
    """The first trial from which on a curve stays near a level; the number of trials if its end is not near."""
    away = curves > NEAR * level
    trials = curves.shape[-1]
    last_away = trials - 1 - np.argmax(away[..., ::-1], axis=-1)
    return np.where(away.any(axis=-1), last_away + 1.0, 0.0)
