"""Margins: how far a number lies inside of a range, as the logarithm of a factor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds

#: Margins are cut here: a number of the wrong sign, and one beyond a limit of 0, have no factor.
MOST = math.log(100)


def interval(numbers: Bounds) -> tuple[float, float]:
    """Return the ends of the middle 95 % of resamples, those of the bounds where these differ; NaN if not defined.

    Args:
        numbers: (1 + resamples,) the measured value first.
    """
    low, high = numbers.low[1:], numbers.high[1:]
    if not len(low) or np.isnan(low).any() or np.isnan(high).any():
        return math.nan, math.nan
    ends = np.percentile(low, 2.5, method="lower"), np.percentile(high, 97.5, method="higher")
    return float(ends[0]), float(ends[1])


def smallest(numbers: Sequence[Bounds]) -> Bounds:
    """Return the bounds of the smallest of these numbers."""
    return Bounds(np.min([each.low for each in numbers], axis=0), np.min([each.high for each in numbers], axis=0))


@dataclass(frozen=True)
class Margin:
    """The margin of a number in a range: positive inside, 0 on a limit, negative outside.

    Where the number is censored, only bounds of its margin are known.

    Attributes:
        worst, best: (1 + resamples,) lower and upper bounds.
    """

    worst: FloatArray
    best: FloatArray

    @classmethod
    def of(cls, numbers: Bounds, low: float, high: float) -> Margin:
        """Return the margin of numbers in a range.

        Args:
            numbers: (1 + resamples,) under the equal weighting of the periods, which gives the measured value, and
                in resamples; what is not defined, such as 0 / 0, may be anything.
            low: lower end of the range; may be minus infinity.
            high: upper end of the range; may be infinity.
        """
        least = np.where(np.isnan(numbers.low), -np.inf, numbers.low)
        most = np.where(np.isnan(numbers.high), np.inf, numbers.high)
        return cls(
            np.minimum(_above(least, low), _below(most, high)),
            np.minimum(_above(most, low), _below(least, high)),
        )

    def __and__(self, other: Margin) -> Margin:
        return Margin(np.minimum(self.worst, other.worst), np.minimum(self.best, other.best))

    def __or__(self, other: Margin) -> Margin:
        return Margin(np.maximum(self.worst, other.worst), np.maximum(self.best, other.best))

    @property
    def holds(self) -> bool | None:
        """Whether the measured value lies inside; None if that cannot be told of a censored one."""
        if self.worst[0] >= 0:
            return True
        return False if self.best[0] < 0 else None

    @property
    def certainty(self) -> float:
        """Share of the resamples that come out as the measured value does; NaN if it cannot be told how that does."""
        holds = self.holds
        if holds is None or len(self.worst) < 2:
            return math.nan
        same = self.worst[1:] >= 0 if holds else self.best[1:] < 0
        return float(same.mean())

    @property
    def value(self) -> float:
        """The margin of the measured value; the bound that decides, or 0 if none does."""
        holds = self.holds
        return 0.0 if holds is None else float(self.worst[0] if holds else self.best[0])


def _above(numbers: FloatArray, limit: float) -> FloatArray:
    if limit == -math.inf:
        return np.full(numbers.shape, MOST)
    if limit <= 0:
        return np.sign(numbers - limit) * MOST
    with np.errstate(divide="ignore"):
        return np.clip(np.log(np.maximum(numbers, 0) / limit), -MOST, MOST)


def _below(numbers: FloatArray, limit: float) -> FloatArray:
    if limit == math.inf:
        return np.full(numbers.shape, MOST)
    if limit <= 0:
        return np.sign(limit - numbers) * MOST
    with np.errstate(divide="ignore"):
        return np.clip(-np.log(np.maximum(numbers, 0) / limit), -MOST, MOST)
