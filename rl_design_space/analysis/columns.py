"""Numbers of designs by period, of which some designs may have more than others."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

#: Distance of a far outlier from the quartiles, in distances between them: one exponential number in 250,000 is so far.
_FAR_OUT = 10


@dataclass(frozen=True)
class Block:
    """Numbers of the designs that have the same periods.

    Attributes:
        rows: (periods,) which periods, in ascending order.
        designs: (designs,) which designs, in ascending order.
        numbers: (periods, designs)
    """

    rows: NDArray[np.intp]
    designs: NDArray[np.intp]
    numbers: FloatArray


@dataclass(frozen=True)
class Columns:
    """Numbers of designs, a block for those with the same periods.

    As one array with NaN, a few designs with many periods would make the others take ten times their memory and time.

    Attributes:
        blocks: of all designs.
        designs: their number.
        periods: number of periods, all that any design has.
    """

    blocks: tuple[Block, ...]
    designs: int
    periods: int

    @classmethod
    def of_array(cls, each: FloatArray) -> Columns:
        """Return the numbers of (periods, designs), NaN where a design does not have a period."""
        periods, designs = each.shape
        patterns, group = groups(~np.isnan(each))
        places = [(np.flatnonzero(p), np.flatnonzero(group == number)) for number, p in enumerate(patterns)]
        return cls(tuple(Block(*both, each[np.ix_(*both)]) for both in places), designs, periods)

    @classmethod
    def of_designs(cls, each: Iterable[tuple[NDArray[np.intp], FloatArray]], periods: int) -> Columns:
        """Return the numbers of designs.

        Args:
            each: of each design, which periods it has, in ascending order, and their numbers.
            periods: number of periods, all that any design has.
        """
        found: dict[bytes, tuple[NDArray[np.intp], list[int], list[FloatArray]]] = {}
        count = 0
        for design, (rows, numbers) in enumerate(each):
            _, designs, columns = found.setdefault(rows.tobytes(), (rows, [], []))
            designs.append(design)
            columns.append(numbers)
            count += 1
        blocks = (
            Block(rows, np.array(designs), np.stack(columns, axis=1)) for rows, designs, columns in found.values()
        )
        return cls(tuple(blocks), count, periods)

    def __neg__(self) -> Columns:
        blocks = (Block(block.rows, block.designs, -block.numbers) for block in self.blocks)
        return Columns(tuple(blocks), self.designs, self.periods)

    @property
    def is_even(self) -> bool:
        """Whether all designs have all periods."""
        return all(len(block.rows) == self.periods for block in self.blocks)

    @cached_property
    def has(self) -> NDArray[np.bool_]:
        """(blocks, periods) which periods the designs of each block have."""
        found = np.zeros((len(self.blocks), self.periods), dtype=bool)
        for has, block in zip(found, self.blocks, strict=True):
            has[block.rows] = True
        return found

    @property
    def counts(self) -> NDArray[np.intp]:
        """(designs,) numbers of periods."""
        found = np.zeros(self.designs, np.intp)
        for block in self.blocks:
            found[block.designs] = len(block.rows)
        return found

    @property
    def means(self) -> FloatArray:
        """(designs,) means of the periods that each design has."""
        found = np.full(self.designs, np.nan)
        for block in self.blocks:
            if len(block.rows):
                # One after the other, however many designs there are; `sum` would add up a single one in another order.
                found[block.designs] = block.numbers.cumsum(axis=0)[-1] / len(block.rows)
        return found

    def in_common(self, designs: NDArray[np.intp]) -> FloatArray:
        """Return the numbers of some designs in the periods that all of them have, (periods, designs)."""
        parts = [(block, np.isin(block.designs, designs)) for block in self.blocks]
        parts = [(block, which) for block, which in parts if which.any()]
        rows = reduce(np.intersect1d, (block.rows for block, _ in parts))
        found = np.empty((len(rows), len(designs)), order="F")
        for block, which in parts:
            places = np.searchsorted(designs, block.designs[which])
            found[:, places] = block.numbers[np.ix_(np.searchsorted(block.rows, rows), which)]
        return found

    def with_cut(self) -> tuple[Columns, NDArray[np.intp]]:
        """Return these designs and then those with far outliers, these cut, and which designs they are, see `cut`."""
        parts = [cut(block.numbers) for block in self.blocks]
        outlying = [block.designs[which] for block, (_, which) in zip(self.blocks, parts, strict=True)]
        every = np.sort(np.concatenate(outlying))
        blocks = [
            Block(
                block.rows,
                np.append(block.designs, self.designs + np.searchsorted(every, designs)),
                np.hstack([block.numbers, less]),
            )
            for block, designs, (less, _) in zip(self.blocks, outlying, parts, strict=True)
        ]
        return Columns(tuple(blocks), self.designs + len(every), self.periods), every


def cut(each: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """Return the numbers of designs with far outliers, these cut, and which designs they are.

    The mean of what is cut from above is no larger than the mean, so a design that is worse than another one by it is
    worse. And it is known much better: a few periods that fail do not hide that all others are worse as well.

    Args:
        each: (periods, designs)
    """
    if not len(each):
        return each[:, :0], np.zeros(0, np.intp)
    low, high = np.quantile(each, (0.25, 0.75), axis=0)
    limit = high + _FAR_OUT * (high - low)
    which = np.flatnonzero((high > low) & (each.max(axis=0) > limit))
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
