"""Numbers of which some are known only to exceed a limit: arithmetic with their lower and upper bounds.

A measure that a point never reaches, such as the first trial from which on its curve is near the optimum, is censored:
it is at least the number of trials. Differences and ratios of such numbers have bounds, too, and only those are
compared.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rl_design_space._arrays import FloatArray


class Bounds(NamedTuple):
    """Lower and upper bounds of numbers; equal where a number is known.

    Attributes:
        low: lower bounds.
        high: upper bounds; infinity where a number is censored.
    """

    low: FloatArray
    high: FloatArray

    def over(self, other: Bounds) -> Bounds:
        """Return bounds of the ratios of two kinds of numbers, none of them negative; NaN for 0 / 0.

        Nothing is divided by a censored number: of such a ratio nothing is known.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high = self.low / other.low, self.high / other.low
        never = np.isinf(other.high)
        return Bounds(np.where(never, 0.0, low), np.where(never, np.inf, high)) if never.any() else Bounds(low, high)

    def minus(self, other: Bounds) -> Bounds:
        """Return bounds of the differences of two kinds of numbers."""
        return Bounds(self.low - other.high, self.high - other.low)

    def row(self, index: int) -> Bounds:
        """Return one row of several."""
        return Bounds(self.low[index], self.high[index])


def known(numbers: FloatArray) -> Bounds:
    """Return the bounds of numbers that are known."""
    return Bounds(numbers, numbers)


def stacked(rows: list[Bounds]) -> Bounds:
    """Return rows of numbers as one array with a first axis more."""
    return Bounds(np.array([row.low for row in rows]), np.array([row.high for row in rows]))
