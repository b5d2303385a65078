"""Paired differences between designs: their size, their standard error and skew, and what chance does to them all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Skew of a difference, over the root of the number of periods, below which it counts as symmetric.
_NO_SKEW = 1e-6
#: Distance of a far outlier from the quartiles, in distances between them: one exponential number in 250,000 is so far.
_FAR_OUT = 10


class Pairs(Protocol):
    """Differences of all designs from one; a small value is good."""

    @property
    def values(self) -> FloatArray:
        """(designs,) values of the designs, each over its own periods."""
        ...

    @property
    def ranked(self) -> NDArray[np.intp]:
        """(designs,) those with most periods first, and among these the best first."""
        ...

    def differences(self, other: int) -> FloatArray:
        """Return (designs,) values minus that of another design, over the periods that both have."""
        ...

    def spread(self, other: int) -> tuple[FloatArray, FloatArray]:
        """Return (designs,) standard errors of the differences, and the skew of their means."""
        ...

    def periods(self, other: int) -> NDArray[np.int64]:
        """Return (designs,) the numbers of periods that the differences are over."""
        ...

    def drawn(self, other: int) -> FloatArray:
        """Return (draws, designs) how far chance moves the differences, all of them together."""
        ...


@dataclass(frozen=True)
class ResampledPairs:
    """Designs whose values are no means of periods; the skew of differences is not known.

    Attributes:
        values: (designs,)
        samples: (resamples, designs) values of resampled periods, the same periods in all designs.
        count: number of periods.
    """

    values: FloatArray
    samples: FloatArray
    count: int

    @property
    def ranked(self) -> NDArray[np.intp]:
        return np.argsort(self.values, kind="stable")

    def differences(self, other: int) -> FloatArray:
        return np.asarray(self.values - self.values[other])

    def spread(self, other: int) -> tuple[FloatArray, FloatArray]:
        return (self.samples - self.samples[:, [other]]).std(axis=0, ddof=1), np.zeros(len(self.values))

    def periods(self, other: int) -> NDArray[np.int64]:
        return np.full(len(self.values), self.count)

    def drawn(self, other: int) -> FloatArray:
        away = self.samples - self.values
        return np.asarray(away - away[:, [other]])


class PeriodPairs:
    """Designs whose values are means of periods, of which some designs may have more than others.

    Args:
        each: (periods, designs) numbers that the values are means of; NaN where a design does not have a period.
        draws: number of draws.
    """

    def __init__(self, each: FloatArray, draws: int) -> None:
        self._each, self._draws = each, draws
        self.values: FloatArray = np.nanmean(each, axis=0)
        has = ~np.isnan(each)
        self._counts = has.sum(axis=0)
        #: Which periods the designs of each group have, and the group of each design.
        self._patterns, self._group = groups(has)
        self._members = [np.flatnonzero(self._group == group) for group in range(len(self._patterns))]
        #: Means and draws of the designs of one group, over the periods that another group has as well.
        self._known: dict[tuple[str, int, int], NDArray[np.floating[Any]]] = {}
        #: Deviations of the designs of each group from their means, over the periods that the group asked for last has.
        self._away: tuple[int, dict[int, NDArray[np.float32]]] = -1, {}

    @property
    def ranked(self) -> NDArray[np.intp]:
        return np.lexsort((self.values, -self._counts))

    def differences(self, other: int) -> FloatArray:
        found = np.empty(len(self.values))
        for group, rows in self._groups(other):
            found[self._members[group]] = self._minus("mean", other, group, rows)
        return found

    def spread(self, other: int) -> tuple[FloatArray, FloatArray]:
        error, skew = np.empty(len(self.values)), np.empty(len(self.values))
        for group, rows in self._groups(other):
            members, count = self._members[group], len(rows)
            away = self._deviations(other, group, rows) - self._centred(rows, np.array([other]))
            squares = away * away
            second = squares.mean(axis=0, dtype=np.float64)
            squares *= away
            skew[members] = ratio(squares.mean(axis=0, dtype=np.float64), second**1.5) / np.sqrt(count)
            error[members] = np.sqrt(second / (count - 1))
        return error, skew

    def periods(self, other: int) -> NDArray[np.int64]:
        found = np.empty(len(self.values), np.int64)
        for group, rows in self._groups(other):
            found[self._members[group]] = len(rows)
        return found

    def drawn(self, other: int) -> FloatArray:
        """Return normal variables with the covariances of the differences, by multipliers of the periods."""
        found = np.empty((self._draws, len(self.values)))
        for group, rows in self._groups(other):
            found[:, self._members[group]] = self._minus("draws", other, group, rows)
        return found

    def _groups(self, other: int) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Yield each group, and the periods that its designs and another one have in common.

        Raises:
            ValueError: they have fewer than two.
        """
        for group, pattern in enumerate(self._patterns):
            rows = np.flatnonzero(pattern & self._patterns[self._group[other]])
            if len(rows) < 2:
                raise ValueError("two designs have fewer than two periods in common")
            yield group, rows

    def _minus(self, what: str, other: int, group: int, rows: NDArray[np.intp]) -> NDArray[np.floating[Any]]:
        """Return the means, or the draws, of the designs of a group minus those of another design.

        Those of equal designs are equal bit for bit, because they are columns of one computation.
        """
        own = int(self._group[other])
        designs = self._members[group]
        if own != group:
            designs = np.append(designs, self._members[own])
        if (known := self._known.get((what, own, group))) is None:
            compute = self._mean if what == "mean" else self._multiplied
            known = self._known[what, own, group] = compute(rows, designs)
        return known[..., : len(self._members[group])] - known[..., designs == other]

    def _mean(self, rows: NDArray[np.intp], designs: NDArray[np.intp]) -> FloatArray:
        return np.asarray(self._each[np.ix_(rows, designs)].mean(axis=0))

    def _deviations(self, other: int, group: int, rows: NDArray[np.intp]) -> NDArray[np.float32]:
        own = int(self._group[other])
        if self._away[0] != own:
            self._away = own, {}
        known = self._away[1]
        if group not in known:
            known[group] = self._centred(rows, self._members[group])
        return known[group]

    def _centred(self, rows: NDArray[np.intp], designs: NDArray[np.intp]) -> NDArray[np.float32]:
        """Return (rows, designs) deviations from the means over these rows."""
        block = self._each[np.ix_(rows, designs)]
        return np.asarray(block - block.mean(axis=0), np.float32)

    def _multiplied(self, rows: NDArray[np.intp], designs: NDArray[np.intp]) -> NDArray[np.float32]:
        """Return (draws, designs) normal variables with the covariances of the means over these rows.

        A period has the same multiplier in all of them, so that means over some of the periods hang together with
        those over all of them.
        """
        multipliers = np.random.default_rng(0).standard_normal((self._draws, len(self._each)))[:, rows]
        multipliers -= multipliers.mean(axis=1, keepdims=True)
        return np.asarray(multipliers.astype(np.float32) @ self._centred(rows, designs) / np.float32(len(rows)))


def cut(each: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return the numbers of designs with far outliers, these cut, and which designs they are.

    The mean of what is cut from above is no larger than the mean, so a design that is worse than another one by it is
    worse. And it is known much better: a few periods that fail do not hide that all others are worse as well.

    Args:
        each: (periods, designs), NaN where a design does not have a period.
    """
    low, high, most = (np.full(each.shape[1], np.nan) for _ in range(3))
    patterns, group = groups(~np.isnan(each))
    for number, pattern in enumerate(patterns):
        if pattern.any():
            members = group == number
            own = each[np.ix_(pattern, members)]
            low[members], high[members] = np.quantile(own, (0.25, 0.75), axis=0)
            most[members] = own.max(axis=0)
    limit = high + _FAR_OUT * (high - low)
    which = np.flatnonzero((high > low) & (most > limit))
    return np.minimum(each[:, which], limit[which]), which


def groups(has: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Return which periods the designs of each group have, (groups, periods), and the group of each design.

    Whole columns are compared as bytes; `np.unique` compares them period by period, which takes a thousand times as
    long.

    Args:
        has: (periods, designs) whether each design has each period.
    """
    packed = np.ascontiguousarray(np.packbits(has, axis=0).T)
    keys = np.array([None, *(column.tobytes() for column in packed)], dtype=object)[1:]
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    return has[:, first].T, group


def reach(quantile: FloatArray | float, skew: FloatArray) -> FloatArray:
    """Return the number of standard errors that a bound lies above each difference.

    Args:
        quantile: the number for a difference without skew.
        skew: of the mean differences.
    """
    skew = np.where(np.abs(skew) < _NO_SKEW, _NO_SKEW, skew)
    return np.asarray(np.maximum(quantile, 3 / skew * (1 - np.cbrt(1 - skew * (quantile + skew / 6)))))


def ratio(away: FloatArray, error: FloatArray) -> FloatArray:
    """Return away / error; 0 where both are 0, infinity with the sign of `away` where only the error is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.asarray(away / error)
    return np.where(np.isnan(found), 0.0, found)


def better(leader: FloatArray, rows: NDArray[np.intp], each: FloatArray, quantile: FloatArray) -> NDArray[np.bool_]:
    """Return whether a leader is better beyond doubt than designs that have some of its periods, (designs,).

    Args:
        leader: (periods,)
        rows: periods that the designs have.
        each: (rows, designs)
        quantile: (designs,) numbers of standard errors that are beyond doubt.
    """
    count = len(rows)
    away = each - leader[rows, np.newaxis]
    gap = away.mean(axis=0)
    away -= gap
    square = away * away
    second = square.mean(axis=0)
    square *= away
    skew = ratio(square.mean(axis=0), second**1.5) / np.sqrt(count)
    # Long periods of the leader that the other design has not come to.
    unmet = max(0.0, leader.var() - leader[rows].var())
    error = np.sqrt((second + unmet) / (count - 1))
    return np.asarray((gap > 0) & (gap > error * reach(quantile, -skew)))
