"""Numbers of which some are bounds: "never" is at least the number of trials, and no ratio is formed with it.

A first trial from which on a curve stays near a level is at most the last trial. A curve that is never near has the
number of trials instead: at least so many would be needed. See `Measure.censored_at`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import percentile_interval
from rl_design_space.learning.measure_kinds import PeriodMeasure
from rl_design_space.learning.measure_statistics import means_of_each
from rl_design_space.learning.measures import Measure, Periods

#: Why a ratio is not known, for messages.
NO_RATIO = "no ratio is formed with a trial that is never reached"


@dataclass(frozen=True, eq=False)
class Censored:
    """Numbers of which some are bounds.

    Attributes:
        values: the numbers; NaN where nothing is known.
        at_least: which of them are lower bounds.
        at_most: which of them are upper bounds.
    """

    values: FloatArray
    at_least: NDArray[np.bool_]
    at_most: NDArray[np.bool_]

    @classmethod
    def of(cls, measured: Measure, periods: Periods, weights: FloatArray) -> Censored:
        """Return a measure under each weighting of the periods, see `Measure.samples`."""
        return cls._of_samples(measured, periods, measured.samples(periods, weights))

    @classmethod
    def of_each(cls, measured: Measure, points: Sequence[Periods], weights: FloatArray) -> list[Censored]:
        """Return a measure of several points of equal size; means are computed of all of them at once."""
        if len(points) < 2 or not isinstance(measured, PeriodMeasure) or not measured.statistic.is_mean:
            return [cls.of(measured, periods, weights) for periods in points]
        means = means_of_each(weights, np.array([measured.of(periods) for periods in points], np.float64))
        return [cls._of_samples(measured, *each) for each in zip(points, means, strict=True)]

    @classmethod
    def _of_samples(cls, measured: Measure, periods: Periods, values: FloatArray) -> Censored:
        never = measured.censored_at(periods)
        at_least = values >= (math.inf if never is None else never)
        return cls(values, at_least, np.zeros_like(at_least))

    def __add__(self, other: Censored) -> Censored:
        at_least, at_most = self.at_least | other.at_least, self.at_most | other.at_most
        return Censored(np.where(at_least & at_most, np.nan, self.values + other.values), at_least, at_most)

    def __sub__(self, other: Censored) -> Censored:
        return self + other.times(-1)

    def times(self, factor: float) -> Censored:
        """Return the numbers multiplied by a factor; a negative one makes upper bounds of lower ones."""
        bounds = (self.at_least, self.at_most) if factor > 0 else (self.at_most, self.at_least)
        return Censored(factor * self.values, *bounds)

    def over(self, other: Censored) -> FloatArray:
        """Return the ratios; NaN where one of both numbers is a bound, and where both are 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = self.values / other.values
        return np.where(self.at_least | self.at_most | other.at_least | other.at_most, np.nan, ratio)

    @classmethod
    def mean(cls, parts: Sequence[Censored]) -> Censored:
        """Return the means, place by place."""
        at_least = np.any([part.at_least for part in parts], axis=0)
        at_most = np.any([part.at_most for part in parts], axis=0)
        mean = np.mean([part.values for part in parts], axis=0)
        return cls(np.where(at_least & at_most, np.nan, mean), at_least, at_most)

    @classmethod
    def joined(cls, parts: Sequence[Censored]) -> Censored:
        """Return all numbers, one after the other."""
        values, at_least, at_most = (
            np.concatenate([getattr(part, name) for part in parts]) for name in ("values", "at_least", "at_most")
        )
        return cls(values, at_least, at_most)


class Bounded(NamedTuple):
    """A value and its 95 % interval, of which each number may be a bound.

    Attributes:
        value: the value.
        low: lower end of the interval.
        high: upper end of the interval.
        bounds: which of them are bounds, and which way: `value ≥, high ≥`; empty if all are exact.
    """

    value: float
    low: float
    high: float
    bounds: str = ""

    @classmethod
    def of(cls, value: Censored, samples: Censored | None) -> Bounded:
        """Return the estimate of a value.

        Args:
            value: the value, (1,).
            samples: bootstrap samples of it, (resamples,); None if it cannot be resampled.
        """
        signs = {"value": _sign(bool(value.at_least[0]), bool(value.at_most[0]))}
        low, high = math.nan, math.nan
        if samples is not None and not np.isnan(samples.values).any():
            low, high = map(float, percentile_interval(samples.values))
            for name, end in (("low", low), ("high", high)):
                below, above = samples.at_least & (samples.values <= end), samples.at_most & (samples.values >= end)
                signs[name] = _sign(bool(below.any()), bool(above.any()))
        bounds = ", ".join(f"{name} {sign}" for name, sign in signs.items() if sign)
        return cls(float(value.values[0]), low, high, bounds)


def _sign(at_least: bool, at_most: bool) -> str:
    """Return the sign of a bound; empty of an exact number, and of one of which nothing is known."""
    if at_least == at_most:
        return ""
    return "≥" if at_least else "≤"
