"""Statistics: how the numbers of periods become one number.

Each but the median is the mean over a slice of the periods in ascending order, by weight: the middle half, or the worst
1 %. A period at the edge of a slice counts with its share that lies inside.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError

#: Weights that differ by less are equal.
_TINY = 1e-9
#: Sums of weights that are computed at once; few enough for the cache of a core.
_AT_ONCE = 130_000
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

        Resampled quantiles lie a few standard errors from the middle, so weights are summed up one by one only there.
        """
        periods, columns = ordered.shape
        reach = math.ceil(3 * math.sqrt(periods)) + 1
        start = max(0, int(self.low * periods) - reach)
        before = np.zeros(ordered.shape)
        np.put_along_axis(before, order[:start], 1.0, axis=0)
        base = weights @ before
        every = np.arange(columns)
        found = np.empty((len(weights), columns))
        for rows in _blocks(len(weights), columns):
            transposed = np.ascontiguousarray(weights[rows].T)
            first, last = self._places(transposed, order, base[rows].T, start)
            beyond = (base[rows] >= self.low - _TINY).any(axis=0)
            if beyond.any():
                nothing = np.zeros((beyond.sum(), len(base[rows])))
                first[beyond], last[beyond] = self._places(transposed, order[:, beyond], nothing, 0)
            last = np.minimum(last, periods - 1)
            found[rows] = (ordered[first.T, every] + ordered[last.T, every]) / 2
        return found

    def _places(
        self, weights: FloatArray, order: NDArray[np.intp], base: FloatArray, start: int
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return where the weight of all values up to one of them reaches the quantile, and where it exceeds it.

        Args:
            weights: (periods, resamples)
            order: (periods, columns) the periods of each column in ascending order of their values.
            base: (columns, resamples) weight of the periods before `start`.
            start: the first place that may be found.

        Returns:
            (columns, resamples) each; the number of periods if there is none.
        """
        upto = base.copy()
        first, last = (np.full(base.shape, start, dtype=np.intp) for _ in range(2))
        for periods in order[start:]:
            upto += weights[periods]
            is_below = upto < self.low + _TINY
            if not is_below.any():
                break
            last += is_below
            first += upto < self.low - _TINY
        return first, last


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
    rows = max(4, _ONE_THREAD // len(values) // 4 * 4)
    return np.concatenate([weights[begin : begin + rows] @ values for begin in range(0, len(weights), rows)])


def _blocks(resamples: int, numbers: int) -> list[slice]:
    """Divide resamples of so many numbers each into blocks."""
    rows = max(1, _AT_ONCE // numbers)
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
