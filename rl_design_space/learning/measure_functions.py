"""The functions that measures are made of."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.measure_kinds import Periods

#: Trials at the end of a period that stand for the final policy.
FINAL_TRIALS = 10
#: A curve or policy is near a level, such as the optimum, within this factor.
NEAR = 1.1
#: A trial that takes so many times the fewest steps possible is an outlier.
OUTLIER = 10


def scaled_to_equal_steps(steps: Any, side: Any) -> Any:
    """Return steps on a d×d grid in steps on a 10×10 grid of the same extent: divided by d/10 (Table 4)."""
    return steps * 10 / side


def converged(curves: FloatArray, level: FloatArray, near: float = NEAR) -> FloatArray:
    """Return the first trial from which on a curve stays near a level; the number of trials if its end is not near.

    Args:
        curves: (..., trials)
        level: (..., 1)
        near: factor within which the curve is near.
    """
    away = curves > near * level
    trials = curves.shape[-1]
    last_away = trials - 1 - np.argmax(away[..., ::-1], axis=-1)
    return np.where(away.any(axis=-1), last_away + 1.0, 0.0)


def gap_level(curves: FloatArray, closed: float) -> FloatArray:
    """Return the level, (..., 1), at which a share of the gap between the first trial and the optimum is closed."""
    level: FloatArray = 1 + (1 - closed) * (curves[..., :1] - 1)
    return level


def gap_left(curves: FloatArray) -> FloatArray:
    """Return the share of the gap between the first trial and the optimum that the final trials leave; NaN of none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        left: FloatArray = (curves[..., -FINAL_TRIALS:].mean(axis=-1) - 1) / (curves[..., 0] - 1)
    return np.where(curves[..., 0] > 1, left, np.nan)


def roughness(curves: FloatArray) -> FloatArray:
    """Return the mean absolute second difference of the logarithm of a curve."""
    rough: FloatArray = np.abs(np.diff(np.log(curves), n=2, axis=-1)).mean(axis=-1)
    return rough


def final_over_optimum(periods: Periods) -> FloatArray:
    """Return (periods,) steps / optimum in the final trials."""
    final: FloatArray = (periods.steps[:, -FINAL_TRIALS:] / periods.optimum[:, np.newaxis]).mean(axis=1)
    return final


def second_half(values: NDArray[Any]) -> FloatArray:
    """Return (periods,) means over the second half of the trials."""
    mean: FloatArray = values[:, values.shape[1] // 2 :].mean(axis=1)
    return mean


def share(which: Any) -> FloatArray:
    """Return truth values as numbers whose mean is a share."""
    return np.asarray(which, np.float64)
