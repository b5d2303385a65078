"""Paired differences between designs: their size, their standard error and skew, and what chance does to them all."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.columns import Block, Columns

#: Skew of a difference, over the root of the number of periods, below which it counts as symmetric.
_NO_SKEW = 1e-6


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
        each: numbers that the values are means of.
        draws: number of draws.
    """

    def __init__(self, each: Columns, draws: int) -> None:
        self._blocks, self._has, self._draws = each.blocks, each.has, draws
        pool = ThreadPoolExecutor(1)
        #: (draws, periods) normal variables, drawn while leaders are compared.
        self._multipliers = pool.submit(np.random.default_rng(0).standard_normal, (draws, each.periods))
        pool.shutdown(wait=False)
        self.values: FloatArray = each.means
        self._counts = each.counts
        #: The block of each design.
        self._block = np.empty(each.designs, np.intp)
        for place, block in enumerate(each.blocks):
            self._block[block.designs] = place
        #: Means and draws of the designs of one block, over the periods that another block has as well.
        self._known: dict[tuple[str, int, int], NDArray[np.floating[Any]]] = {}
        #: Deviations of the designs of each block from their means, over the periods that the block asked for last has.
        self._away: tuple[int, dict[int, NDArray[np.float32]]] = -1, {}

    @property
    def ranked(self) -> NDArray[np.intp]:
        return np.lexsort((self.values, -self._counts))

    def differences(self, other: int) -> FloatArray:
        found = np.empty(len(self.values))
        for place, rows in self._common(other):
            found[self._blocks[place].designs] = self._minus("mean", other, place, rows)
        return found

    def spread(self, other: int) -> tuple[FloatArray, FloatArray]:
        error, skew = np.empty(len(self.values)), np.empty(len(self.values))
        for place, rows in self._common(other):
            designs, count = self._blocks[place].designs, len(rows)
            away = self._deviations(other, place, rows) - self._of_one(other, rows)
            squares = away * away
            second = squares.mean(axis=0, dtype=np.float64)
            squares *= away
            skew[designs] = ratio(squares.mean(axis=0, dtype=np.float64), second**1.5) / np.sqrt(count)
            error[designs] = np.sqrt(second / (count - 1))
        return error, skew

    def periods(self, other: int) -> NDArray[np.int64]:
        found = np.empty(len(self.values), np.int64)
        for place, rows in self._common(other):
            found[self._blocks[place].designs] = len(rows)
        return found

    def drawn(self, other: int) -> FloatArray:
        """Return normal variables with the covariances of the differences, by multipliers of the periods."""
        found = np.empty((self._draws, len(self.values)))
        for place, rows in self._common(other):
            found[:, self._blocks[place].designs] = self._minus("draws", other, place, rows)
        return found

    def _common(self, other: int) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Yield each block, and the periods that its designs and another one have in common.

        Raises:
            ValueError: they have fewer than two.
        """
        own = self._has[self._block[other]]
        for place, has in enumerate(self._has):
            rows = np.flatnonzero(has & own)
            if len(rows) < 2:
                raise ValueError("two designs have fewer than two periods in common")
            yield place, rows

    def _minus(self, what: str, other: int, place: int, rows: NDArray[np.intp]) -> NDArray[np.floating[Any]]:
        """Return the means, or the draws, of the designs of a block minus those of another design.

        Those of equal designs are equal bit for bit, because they are columns of one computation.
        """
        own = int(self._block[other])
        blocks = [self._blocks[which] for which in dict.fromkeys((place, own))]
        if (known := self._known.get((what, own, place))) is None:
            numbers = np.hstack([_in_rows(block, rows) for block in blocks])
            known = numbers.mean(axis=0) if what == "mean" else self._multiplied(rows, numbers)
            self._known[what, own, place] = known
        designs = np.concatenate([block.designs for block in blocks])
        return known[..., : len(blocks[0].designs)] - known[..., designs == other]

    def _of_one(self, other: int, rows: NDArray[np.intp]) -> NDArray[np.float32]:
        """Return (rows, 1) the deviations of a design from its mean over these rows."""
        block = self._blocks[self._block[other]]
        return _centred(_in_rows(block, rows)[:, block.designs == other])

    def _deviations(self, other: int, place: int, rows: NDArray[np.intp]) -> NDArray[np.float32]:
        own = int(self._block[other])
        if self._away[0] != own:
            self._away = own, {}
        known = self._away[1]
        if place not in known:
            known[place] = _centred(_in_rows(self._blocks[place], rows))
        return known[place]

    def _multiplied(self, rows: NDArray[np.intp], numbers: FloatArray) -> NDArray[np.float32]:
        """Return (draws, designs) normal variables with the covariances of the means over these rows.

        A period has the same multiplier in all of them, so that means over some of the periods hang together with
        those over all of them.
        """
        multipliers = self._multipliers.result()[:, rows]
        multipliers -= multipliers.mean(axis=1, keepdims=True)
        return np.asarray(multipliers.astype(np.float32) @ _centred(numbers) / np.float32(len(rows)))


def _in_rows(block: Block, rows: NDArray[np.intp]) -> FloatArray:
    """Return the numbers of a block in some of its periods."""
    return block.numbers if len(rows) == len(block.rows) else block.numbers[np.searchsorted(block.rows, rows)]


def _centred(numbers: FloatArray) -> NDArray[np.float32]:
    """Return (rows, designs) deviations from the means."""
    return np.asarray(numbers - numbers.mean(axis=0), np.float32)


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
