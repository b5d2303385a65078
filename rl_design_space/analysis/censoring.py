"""Numbers that stand for "never": lower bounds, of which no ratio is formed.

A first trial from which on a curve stays near a level is at most the last trial. A curve that is never near has the
number of trials instead: at least so many would be needed. See `Measure.censored_at`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Why a ratio is not known, for messages.
NO_RATIO = "no ratio is formed with a trial that is never reached"


def is_never(values: FloatArray | float, never: float | None) -> NDArray[np.bool_]:
    """Return which values stand for "never".

    Args:
        values: of a measure.
        never: its `censored_at`; None if no value of it stands for that.
    """
    return np.asarray(values) >= (math.inf if never is None else never)


def ratio(
    one: FloatArray, other: FloatArray, one_never: float | None = None, other_never: float | None = None
) -> FloatArray:
    """Return values over others; NaN where one of both stands for "never", and where both are 0.

    Args:
        one: values of a measure.
        other: values of a measure, of the same shape.
        one_never: `censored_at` of the first.
        other_never: `censored_at` of the others.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        over: FloatArray = np.asarray(one) / np.asarray(other)
    return np.where(is_never(one, one_never) | is_never(other, other_never), np.nan, over)


class Difference(NamedTuple):
    """Differences of which some are bounds.

    Attributes:
        values: the differences; NaN where both sides stand for "never".
        at_least: where the first side stands for "never": the difference is that large, or larger.
        at_most: where the other side stands for "never": the difference is that large, or smaller.
    """

    values: FloatArray
    at_least: NDArray[np.bool_]
    at_most: NDArray[np.bool_]


def difference(
    one: FloatArray, other: FloatArray, one_never: float | None = None, other_never: float | None = None
) -> Difference:
    """Return values minus others, see `ratio`."""
    first, second = is_never(one, one_never), is_never(other, other_never)
    values = np.where(first & second, np.nan, np.asarray(one) - np.asarray(other))
    return Difference(values, first & ~second, second & ~first)
