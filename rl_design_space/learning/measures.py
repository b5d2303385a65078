"""Measures: numbers and curves that are computed from the periods of a point.

This table serves recorded scalars, the values of reports (`--value`), claims (`measure:`) and summaries of curves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Trials at the end of a period that stand for the final policy.
FINAL_TRIALS = 10
#: A curve or policy is near a level, such as the optimum, within this factor.
NEAR = 1.1
#: A trial that takes so many times the fewest steps possible is an outlier.
OUTLIER = 10

#: Size of a matrix up to which linear algebra uses one thread to multiply it with a vector.
_ONE_THREAD = 9000

#: Names of the learning curves that are recorded for every point.
CURVES = ("steps/mean", "steps/median", "success_rate")
#: Names of the learning curves that are recorded on demand; the artifact of a run always holds them.
CURVES_ON_DEMAND = ("steps/q10", "steps/q90", "steps/over_optimum", "epsilon")
#: Names of the recorded scalars, see `LearningCurves.scalars`.
SCALARS = (
    "total_steps",
    "total_steps_sem",
    "total_steps_scaled",
    "failed_trials",
    "failed_periods",
    "final_steps_over_optimum",
    "env_steps_per_second",
)


class Periods(Protocol):
    """Periods of a point, from which measures are computed, see `LearningCurves`."""

    @property
    def steps(self) -> NDArray[np.int32]:
        """(periods, trials) steps until the final goal; the step cap where it was missed."""
        ...

    @property
    def success(self) -> NDArray[np.bool_]:
        """(periods, trials) whether the final goal was reached."""
        ...

    @property
    def optimum(self) -> NDArray[np.int32]:
        """(periods,) fewest steps possible."""
        ...

    @property
    def over_optimum(self) -> FloatArray:
        """(periods, trials) steps / optimum."""
        ...

    @property
    def total_steps(self) -> FloatArray:
        """(periods,) steps of all trials."""
        ...

    @property
    def side(self) -> float:
        """Cells along each side of the grid; NaN if it is not square, or not known."""
        ...


class Measure(Protocol):
    """A number that is computed from the periods of a point."""

    @property
    def meaning(self) -> str:
        """What it measures, as a noun phrase."""
        ...

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        """Return the measure under each weighting of the periods.

        Args:
            periods: periods of the point.
            weights: (resamples, periods), each row sums to 1; equal weights give the plain value.

        Returns:
            (resamples,)
        """
        ...

    def each(self, periods: Periods) -> FloatArray | None:
        """Return (periods,) numbers whose mean is the measure; None if it is computed from the mean curve."""
        ...


@dataclass(frozen=True)
class PeriodMeasure:
    """A mean over periods of one number each.

    Attributes:
        meaning: what it measures.
        of: (periods,) float64, the number of each period.
    """

    meaning: str
    of: Callable[[Periods], FloatArray]

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        return weighted_means(weights, self.of(periods))

    def each(self, periods: Periods) -> FloatArray | None:
        return self.of(periods)


@dataclass(frozen=True)
class CurveMeasure:
    """A number that is computed from the mean curve, over periods, of steps / optimum.

    Attributes:
        meaning: what it measures.
        of: (..., trials) curves to (...,) numbers.
    """

    meaning: str
    of: Callable[[FloatArray], FloatArray]

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        return self.of(weights @ periods.over_optimum)

    def each(self, periods: Periods) -> FloatArray | None:
        return None


def weighted_means(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return `weights @ values`, (resamples,), in blocks that are too small for linear algebra to start threads for.

    Threads take longer to start than to compute this, and several times longer where all cores are busy.

    Args:
        weights: (resamples, periods)
        values: (periods,)
    """
    rows = max(4, _ONE_THREAD // len(values) // 4 * 4)
    means: FloatArray = np.concatenate(
        [weights[begin : begin + rows] @ values for begin in range(0, len(weights), rows)]
    )
    return means


def scaled_to_equal_steps(steps: Any, side: Any) -> Any:
    """Return steps on a d×d grid in steps on a 10×10 grid of the same extent: divided by d/10 (Table 4)."""
    return steps * 10 / side


def converged(curves: FloatArray, level: FloatArray) -> FloatArray:
    """Return the first trial from which on a curve stays near a level; the number of trials if its end is not near.

    Args:
        curves: (..., trials)
        level: (..., 1)
    """
    away = curves > NEAR * level
    trials = curves.shape[-1]
    last_away = trials - 1 - np.argmax(away[..., ::-1], axis=-1)
    return np.where(away.any(axis=-1), last_away + 1.0, 0.0)


def _final_over_optimum(periods: Periods) -> FloatArray:
    final: FloatArray = (periods.steps[:, -FINAL_TRIALS:] / periods.optimum[:, np.newaxis]).mean(axis=1)
    return final


def _second_half(values: NDArray[Any]) -> FloatArray:
    mean: FloatArray = values[:, values.shape[1] // 2 :].mean(axis=1)
    return mean


def _share(which: Any) -> FloatArray:
    return np.asarray(which, np.float64)


MEASURES: Mapping[str, Measure] = {
    "total_steps": PeriodMeasure(
        "steps of all trials of a period, mean over periods", lambda periods: periods.total_steps
    ),
    "total_steps_scaled": PeriodMeasure(
        "total steps · 10/d, steps of equal length on square grids of any size d",
        lambda periods: scaled_to_equal_steps(periods.total_steps, periods.side),
    ),
    "late_steps": PeriodMeasure(
        "steps of a trial in the second half of the trials", lambda periods: _second_half(periods.steps)
    ),
    "failed_trials": PeriodMeasure(
        "share of trials that miss the final goal", lambda periods: 1 - _share(periods.success.mean(axis=1))
    ),
    "failed_periods": PeriodMeasure(
        "share of periods with a trial that misses the final goal",
        lambda periods: 1 - _share(periods.success.all(axis=1)),
    ),
    "final_steps_over_optimum": PeriodMeasure(
        f"steps / optimum in the last {FINAL_TRIALS} trials", _final_over_optimum
    ),
    "final_failed": PeriodMeasure(
        f"share of the last {FINAL_TRIALS} trials that miss the final goal",
        lambda periods: _share((~periods.success[:, -FINAL_TRIALS:]).mean(axis=1)),
    ),
    "not_near_optimum": PeriodMeasure(
        f"share of periods whose last {FINAL_TRIALS} trials need more than {NEAR} times the optimum",
        lambda periods: _share(_final_over_optimum(periods) > NEAR),
    ),
    "outliers": PeriodMeasure(
        f"share of trials in the second half that need more than {OUTLIER} times the optimum",
        lambda periods: _second_half(periods.over_optimum > OUTLIER),
    ),
    "trials_to_final": CurveMeasure(
        f"trials until the mean curve of steps / optimum stays within {NEAR} times its final level",
        lambda curves: converged(curves, curves[..., -FINAL_TRIALS:].mean(axis=-1, keepdims=True)),
    ),
    "trials_to_optimum": CurveMeasure(
        f"trials until the mean curve of steps / optimum stays within {NEAR}",
        lambda curves: converged(curves, np.ones_like(curves[..., :1])),
    ),
    "roughness": CurveMeasure(
        "mean absolute second difference of the logarithm of the mean curve of steps / optimum",
        lambda curves: np.abs(np.diff(np.log(curves), n=2, axis=-1)).mean(axis=-1),
    ),
}
#: Alternative names of measures.
ALIASES = {"final_over_optimum": "final_steps_over_optimum"}
#: Learning curves that are means over periods, by name, and (periods, trials) values that they are means of.
CURVES_OF_PERIODS: Mapping[str, Callable[[Periods], NDArray[Any]]] = {
    "steps/mean": lambda periods: periods.steps,
    "steps/over_optimum": lambda periods: periods.over_optimum,
    "success_rate": lambda periods: periods.success,
}


def measure(name: str) -> Measure:
    """Return the measure of a name or alias.

    Raises:
        KeyError: there is none.
    """
    return MEASURES[ALIASES.get(name, name)]
