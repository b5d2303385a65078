"""Margins: how far a number lies inside of a range, as the logarithm of a factor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds

#: Margins are cut here: a number of the wrong sign, and one beyond a limit of 0, have no factor.
MOST = math.log(100)

Booleans = NDArray[np.bool_]


def interval(numbers: Bounds) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the middle 95 % of resamples, those of the bounds where these differ; NaN if not defined.

    Args:
        numbers: (..., 1 + resamples) the measured value first.

    Returns:
        (...,) each.
    """
    low, high = numbers.low[..., 1:], numbers.high[..., 1:]
    nothing = np.full(low.shape[:-1], np.nan)
    if not low.shape[-1]:
        return nothing, nothing
    undefined = np.isnan(low).any(axis=-1) | np.isnan(high).any(axis=-1)
    ends = (
        np.percentile(low, 2.5, axis=-1, method="lower"),
        np.percentile(high, 97.5, axis=-1, method="higher"),
    )
    return np.where(undefined, np.nan, ends[0]), np.where(undefined, np.nan, ends[1])


def smallest(numbers: Sequence[Bounds]) -> Bounds:
    """Return the bounds of the smallest of these numbers."""
    return Bounds(np.min([each.low for each in numbers], axis=0), np.min([each.high for each in numbers], axis=0))


@dataclass(frozen=True)
class Margin:
    """The margin of a number in a range: positive inside, 0 on a limit, negative outside.

    Where the number is censored, only bounds of its margin are known.

    Attributes:
        worst, best: (..., 1 + resamples) lower and upper bounds.
    """

    worst: FloatArray
    best: FloatArray

    @classmethod
    def of(cls, numbers: Bounds, low: float, high: float) -> Margin:
        """Return the margin of numbers in a range.

        Args:
            numbers: (..., 1 + resamples) under the equal weighting of the periods, which gives the measured value, and
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
    def holds(self) -> Booleans:
        """Whether the measured value lies inside."""
        return np.asarray(self.worst[..., 0] >= 0)

    @property
    def fails(self) -> Booleans:
        """Whether the measured value lies outside; of a censored one neither this nor that may be told."""
        return np.asarray(~self.holds & (self.best[..., 0] < 0))

    @property
    def certainty(self) -> FloatArray:
        """Share of the resamples that come out as the measured value does; NaN if it cannot be told how that does."""
        holds, fails = self.holds, self.fails
        if self.worst.shape[-1] < 2:
            return np.full(holds.shape, np.nan)
        inside, outside = (self.worst[..., 1:] >= 0).mean(axis=-1), (self.best[..., 1:] < 0).mean(axis=-1)
        return np.where(holds, inside, np.where(fails, outside, np.nan))

    @property
    def value(self) -> FloatArray:
        """The margin of the measured value; the bound that decides, or 0 if none does."""
        return np.where(self.holds, self.worst[..., 0], np.where(self.fails, self.best[..., 0], 0.0))


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
