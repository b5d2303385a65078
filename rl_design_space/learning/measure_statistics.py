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
#: Weights that are cumulated at once; few enough for the cache of a core.
_AT_ONCE = 130_000
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
            mean: FloatArray = weights @ values
            return mean
        columns = np.asarray(values, np.float64).reshape(len(values), -1)
        order = np.argsort(columns, axis=0, kind="stable")
        ordered = np.take_along_axis(columns, order, axis=0)
        found = (self._of_slice if self.low < self.high else self._of_middle)(ordered, order, weights)
        return found.reshape(len(weights), *values.shape[1:])

    def _of_slice(self, ordered: FloatArray, order: NDArray[np.intp], weights: FloatArray) -> FloatArray:
        found = np.empty((len(weights), ordered.shape[1]))
        for rows in _blocks(weights):
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
        centre = int(self.low * periods)
        start, stop = max(0, centre - reach), min(periods, centre + reach)
        before = np.zeros(ordered.shape)
        np.put_along_axis(before, order[:start], 1.0, axis=0)
        base = weights @ before
        found = np.empty((len(weights), columns))
        for rows in _blocks(weights):
            transposed = np.ascontiguousarray(weights[rows].T)
            for column in range(columns):
                upto = transposed[order[start:stop, column]]
                upto[0] += base[rows, column]
                np.cumsum(upto, axis=0, out=upto)
                first, last = (place + start for place in self._places(upto))
                if (base[rows, column] >= self.low - _TINY).any() or (last >= stop).any():
                    first, last = self._places(transposed[order[:, column]].cumsum(axis=0))
                last = np.minimum(last, periods - 1)
                found[rows, column] = (ordered[first, column] + ordered[last, column]) / 2
        return found

    def _places(self, upto: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return where the weight of all values up to one of them reaches the quantile, and where it exceeds it."""
        return (upto < self.low - _TINY).sum(axis=0), (upto < self.low + _TINY).sum(axis=0)


def _blocks(weights: FloatArray) -> list[slice]:
    rows = max(1, _AT_ONCE // weights.shape[1])
    return [slice(start, start + rows) for start in range(0, len(weights), rows)]


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
