"""Kinds of measures: of the numbers of periods, and of a curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, Optimum
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_statistics import MEAN, Statistic, statistic


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
    def optimum(self) -> Optimum:
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
    def scaled_steps(self) -> FloatArray:
        """(periods,) steps of all trials in steps of a 10×10 grid; NaN if a grid is not square, or not known."""
        ...


class Measure(Protocol):
    """A number that is computed from the periods of a point."""

    @property
    def meaning(self) -> str:
        """What it measures, as a noun phrase."""
        ...

    @property
    def largest_is_best(self) -> bool:
        """Whether a larger number is a better one."""
        ...

    @property
    def is_share(self) -> bool:
        """Whether it is the mean of a share, 0 to 1, of each period: then 0 in all periods is not 0 for certain."""
        ...

    @property
    def is_first_trial(self) -> bool:
        """Whether the number is a trial, and the number of trials stands for "never", see `censored_at`."""
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
        """Return (periods,) numbers whose mean is the measure; None if it is not the mean of any."""
        ...

    def censored_at(self, periods: Periods) -> float | None:
        """Return the number that stands for "never": a lower bound, of which no ratio is formed; None if there is none.

        It is shown as `≥ 100`, see `analysis.censoring`.
        """
        ...

    def with_statistic(self, name: str) -> Measure:
        """Return the measure with another statistic than the mean.

        Raises:
            ConfigError: there is no such statistic, or the measure has no use for it.
        """
        ...


@dataclass(frozen=True)
class PeriodMeasure:
    """A statistic over periods of one number each.

    Attributes:
        what: what the number of a period is.
        of: (periods,) float64, the number of each period.
        largest_is_best: whether a larger number is a better one.
        statistic: how the numbers become one.
        of_shares: whether the number of a period is a share.
    """

    what: str
    of: Callable[[Periods], FloatArray]
    largest_is_best: bool = False
    statistic: Statistic = MEAN
    of_shares: bool = False

    @property
    def meaning(self) -> str:
        return f"{self.what}, {self.statistic.meaning}"

    @property
    def is_first_trial(self) -> bool:
        return False

    @property
    def is_share(self) -> bool:
        return self.of_shares and self.statistic.is_mean

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        return self.statistic.of(self.of(periods), weights)

    def each(self, periods: Periods) -> FloatArray | None:
        return self.of(periods) if self.statistic.is_mean else None

    def censored_at(self, periods: Periods) -> float | None:
        return None

    def with_statistic(self, name: str) -> PeriodMeasure:
        return replace(self, statistic=statistic(name, largest_is_best=self.largest_is_best))


@dataclass(frozen=True)
class CurveMeasure:
    """A number that is computed from the mean or median curve, over periods, of steps / optimum.

    Attributes:
        what: what it measures; `{}` stands for `mean` or `median`.
        of: (..., trials) curves to (...,) numbers.
        is_first_trial: whether the number is a trial, and the number of trials stands for "never".
        statistic: how the curves of periods become one.
    """

    what: str
    of: Callable[[FloatArray], FloatArray]
    is_first_trial: bool = False
    statistic: Statistic = MEAN
    largest_is_best: bool = False

    @property
    def meaning(self) -> str:
        return self.what.format(self.statistic.name)

    @property
    def is_share(self) -> bool:
        return False

    def samples(self, periods: Periods, weights: FloatArray) -> FloatArray:
        return self.of(self.statistic.of(periods.over_optimum, weights))

    def each(self, periods: Periods) -> FloatArray | None:
        return None

    def censored_at(self, periods: Periods) -> float | None:
        return float(periods.steps.shape[1]) if self.is_first_trial else None

    def with_statistic(self, name: str) -> CurveMeasure:
        if name not in ("mean", "median"):
            raise ConfigError.at("statistic", name, "should be mean or median, for a measure of a curve")
        return replace(self, statistic=statistic(name))
