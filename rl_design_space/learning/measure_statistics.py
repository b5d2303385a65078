"""Statistics: how the numbers of periods become one number.

Each but the median is the mean over a slice of the periods in ascending order, by weight: the middle half, or the worst
1 %. A period at the edge of a slice counts with its share that lies inside.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError

#: Weights that differ by less are equal.
_TINY = 1e-9
#: Weights that are cumulated at once; few enough for the cache of a core.
_AT_ONCE = 130_000
#: Standard errors between a quantile of all periods and resampled ones, at most, times their standard deviation.
_REACH = 1.8
#: Places of a column that are summed up one after the other, for many resamples at a time.
_PLACES = 100
#: Largest number of one byte, in which counting takes the least time.
_IN_A_BYTE = 127
#: Size of a matrix up to which linear algebra uses one thread to multiply it with a vector.
_ONE_THREAD = 9000
#: Resamples that are not worth dividing into blocks.
_FEW = 1000
_CVAR = re.compile(r"cvar=(\d+(?:\.\d+)?)")


@dataclass(frozen=True)
class Statistic:
    """A statistic of the numbers of periods.

    Attributes:
        name: its text form.
        meaning: what it is, as a noun phrase.
        low, high: the slice of the periods in ascending order, 0 to 1; equal for a quantile.
    """

    name: str
    meaning: str
    low: float = 0.0
    high: float = 1.0

    @property
    def is_mean(self) -> bool:
        """Whether it is the plain mean."""
        return self.name == "mean"

    def of(self, values: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the statistic under each weighting of the periods.

        Args:
            values: (periods,) or (periods, columns), for a statistic of each column.
            weights: (resamples, periods), each row sums to 1.

        Returns:
            (resamples,) or (resamples, columns)
        """
        if self.is_mean:
            return weighted_means(weights, values)
        columns = np.asarray(values, np.float64).reshape(len(values), -1)
        order = np.argsort(columns, axis=0, kind="stable")
        ordered = np.take_along_axis(columns, order, axis=0)
        found = (self._of_slice if self.low < self.high else self._of_middle)(ordered, order, weights)
        return found.reshape(len(weights), *values.shape[1:])

    def _of_slice(self, ordered: FloatArray, order: NDArray[np.intp], weights: FloatArray) -> FloatArray:
        found = np.empty((len(weights), ordered.shape[1]))
        for rows in _blocks(*weights.shape):
            for column, (values, places) in enumerate(zip(ordered.T, order.T, strict=True)):
                upto = weights[rows, places].cumsum(axis=1)
                share = np.diff(np.clip(upto, self.low, self.high), axis=1, prepend=self.low)
                found[rows, column] = share @ values / share.sum(axis=1)
        return found

    def _of_middle(self, ordered: FloatArray, order: NDArray[np.intp], weights: FloatArray) -> FloatArray:
        """Return a quantile: of both middle values their mean, where the weights leave two of them.

        Resampled quantiles lie a few standard errors from that of the mean weights, so weights are summed up one by one
        only there.
        """
        periods, columns = ordered.shape
        total, numbers = _counted(weights)
        limits = (self.low - _TINY) * total, (self.low + _TINY) * total
        start, width = self._window(order, weights)
        window = np.take_along_axis(order, start + np.arange(width)[:, np.newaxis], axis=0)
        found = np.empty((len(weights), columns))
        every = np.arange(columns)[:, np.newaxis]
        for rows in _blocks(len(weights), max(columns, periods // _PLACES)):
            transposed = np.ascontiguousarray(numbers[rows].T)
            base = _summed(transposed, order, start)
            first, last = (start[:, np.newaxis] + places for places in _places(transposed, window, base, limits))
            # Where the quantile of a resample lies elsewhere, weights are compared from the first one on.
            far = (base >= limits[0]) | (last >= start[:, np.newaxis] + width)
            if far.any():
                some, there = np.flatnonzero(far.any(axis=1)), np.flatnonzero(far.any(axis=0))
                among, none = np.ix_(some, there), np.zeros((len(some), len(there)), transposed.dtype)
                first[among], last[among] = _places(transposed[:, there], order[:, some], none, limits)
            last = np.minimum(last, periods - 1)
            found[rows] = ((ordered.T[every, first] + ordered.T[every, last]) / 2).T
        return found

    def _window(self, order: NDArray[np.intp], weights: FloatArray) -> tuple[NDArray[np.intp], int]:
        """Return the first of the places among which resampled quantiles lie, (columns,), and their number."""
        reach = _REACH / math.sqrt(max(1, np.count_nonzero(weights) / len(weights)))
        upto = weights.mean(axis=0)[order].cumsum(axis=0)
        start = np.maximum((upto < self.low - reach).sum(axis=0) - 1, 0)
        width = int(((upto < self.low + reach).sum(axis=0) + 2 - start).max())
        width = min(width, len(order))
        return np.minimum(start, len(order) - width), width


def weighted_means(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return `weights @ values`, of many weights in blocks that are too small for linear algebra to start threads for.

    Threads take longer to start than to multiply a vector, and several times longer where all cores are busy.

    Args:
        weights: (resamples, periods)
        values: (periods,) or (periods, columns)
    """
    if values.ndim > 1 or len(weights) < _FEW:
        product: FloatArray = weights @ values
        return product
    means: FloatArray = means_of_each(weights, values[np.newaxis])[0]
    return means


def means_of_each(weights: FloatArray, values: FloatArray) -> FloatArray:
    """Return `weighted_means` of several arrays of values; each block of weights is read from memory once for all.

    Args:
        weights: (resamples, periods)
        values: (arrays, periods)

    Returns:
        (arrays, resamples)
    """
    resamples, periods = weights.shape
    rows = max(4, _ONE_THREAD // periods // 4 * 4) if resamples >= _FEW else max(1, resamples)
    whole = resamples // rows * rows
    blocks = weights[:whole].reshape(-1, 1, rows, periods)
    found = np.empty((len(values), resamples))
    found[:, :whole] = np.moveaxis((blocks @ values[:, :, np.newaxis])[..., 0], 1, 0).reshape(len(values), whole)
    for each, means in zip(values, found, strict=True):
        means[whole:] = weights[whole:] @ each
    return found


def _counted(weights: FloatArray) -> tuple[float, NDArray[Any]]:
    """Return weights and their sum; as small whole numbers, which is faster, if they are multiples of the least one.

    Those of resamples are: they count how often a period was drawn.
    """
    least = weights.min(initial=1.0, where=weights > 0)
    total = np.rint(1 / least)
    counts = weights * total
    whole = np.rint(counts)
    if total > np.iinfo(np.int16).max or np.abs(counts - whole).max(initial=0) > _TINY:
        return 1.0, weights
    return float(total), whole.astype(np.int16)


def _summed(transposed: NDArray[Any], order: NDArray[np.intp], start: NDArray[np.intp]) -> NDArray[Any]:
    """Return the weight of the values before a place of each column, (columns, resamples); see `_places`."""
    with_none = np.concatenate([transposed, np.zeros_like(transposed[:1])])
    first = order[: start.max(initial=0)]
    upto = np.zeros((order.shape[1], transposed.shape[1]), transposed.dtype)
    for places in np.where(np.arange(len(first))[:, np.newaxis] < start, first, len(transposed)):
        upto += with_none[places]
    return upto


def _places(
    transposed: NDArray[Any], order: NDArray[np.intp], base: NDArray[Any], limits: tuple[float, float]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return with how many of the values, in ascending order, their weight is still below each of two limits.

    Args:
        transposed: (periods, resamples) weights.
        order: (values, columns) periods of the values in ascending order.
        base: (columns, resamples) weight of all values before them.
        limits: both limits.

    Returns:
        (columns, resamples) for each limit.
    """
    upto = base.copy()
    # Whole numbers are compared with whole numbers, so that they need not be converted.
    ends = [math.ceil(limit) if upto.dtype.kind == "i" else limit for limit in limits]
    found = [np.zeros(base.shape, np.intp) for _ in ends]
    for begin in range(0, len(order), _IN_A_BYTE):
        counts = [np.zeros(base.shape, np.int8) for _ in ends]
        for places in order[begin : begin + _IN_A_BYTE]:
            upto += transposed[places]
            for count, end in zip(counts, ends, strict=True):
                count += (upto < end).view(np.int8)
        for below, count in zip(found, counts, strict=True):
            below += count
        if not counts[-1].any():
            break
    return found[0], found[1]


def _blocks(resamples: int, width: int) -> list[slice]:
    rows = max(1, _AT_ONCE // width)
    return [slice(start, start + rows) for start in range(0, resamples, rows)]


MEAN = Statistic("mean", "mean over periods")
MEDIAN = Statistic("median", "median over periods", 0.5, 0.5)
IQM = Statistic("iqm", "mean over the middle half of the periods", 0.25, 0.75)
#: Forms of the names of statistics, for messages and completion.
FORMS = ("mean", "median", "iqm", "cvar=1", "cvar=5")


def statistic(name: str, *, largest_is_best: bool = False) -> Statistic:
    """Return the statistic of a name; `cvar=5` is the mean of the worst 5 % of the periods.

    Args:
        name: one of `FORMS`, or `cvar` with another percentage.
        largest_is_best: whether the worst periods are those with the smallest numbers.

    Raises:
        ConfigError: there is none.
    """
    for known in (MEAN, MEDIAN, IQM):
        if known.name == name:
            return known
    found = _CVAR.fullmatch(name)
    percent = float(found[1]) if found else 0.0
    if not 0 < percent <= 100:
        raise ConfigError.at(
            "statistic", name, f"should be among {', '.join(FORMS)}; cvar=5 is the mean of the worst 5 %"
        )
    share = percent / 100
    low, high = (0.0, share) if largest_is_best else (1 - share, 1.0)
    return Statistic(f"cvar={percent:g}", f"mean over the worst {percent:g} % of the periods", low, high)
