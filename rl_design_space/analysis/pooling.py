"""Periods of several runs: pooled over the seeds of a design, and resampled together where they share their layouts.

docs/decisions/0016-several-seeds.md defines what is done here, and why.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import RESAMPLES, resample_weights

#: Resampled periods of several seeds that are held in memory at once.
_AT_ONCE = 10_000_000
#: Weights of one seed that are held in memory all at once, and cached; the same weights are drawn either way.
_CACHED = 25_000_000


class Repetition(NamedTuple):
    """Where the periods of a run come from.

    Attributes:
        design: everything but the seed; runs of one design differ in their seeds alone.
        seed: runs of one seed have the same layouts and random words, period by period.
    """

    design: Hashable
    seed: Hashable


class _Units(NamedTuple):
    """Periods of one seed.

    Attributes:
        runs: index of the run that each design has of them, by the place of the design.
        start: first period.
        stop: the period after the last one.
    """

    runs: dict[int, int]
    start: int
    stop: int


@dataclass(frozen=True)
class _Stratum:
    """Periods that the same designs have, and which are therefore interchangeable.

    Attributes:
        designs: places of these designs.
        units: these periods, seed by seed.
    """

    designs: tuple[int, ...]
    units: list[_Units]

    @property
    def size(self) -> int:
        return sum(unit.stop - unit.start for unit in self.units)

    def of(self, design: int, runs: Sequence[NDArray[np.generic]]) -> FloatArray:
        """Return the values of a design, (size, …), from those of all runs."""
        return np.concatenate([runs[unit.runs[design]][unit.start : unit.stop] for unit in self.units])


class Pool:
    """The periods of runs, by design and by stratum.

    Args:
        repetitions: where the periods of each run come from.
        periods: number of periods of each run.
    """

    def __init__(self, repetitions: Sequence[Repetition], periods: Sequence[int]) -> None:
        self._periods = periods
        places: dict[Hashable, int] = {}
        seen: set[tuple[Hashable, ...]] = set()
        by_seed: dict[Hashable, dict[int, int]] = {}
        #: Indexes of the runs of each design.
        self.designs: list[list[int]] = []
        for run, (design, seed) in enumerate(repetitions):
            key: Hashable = design
            while (key, seed) in seen:  # a second run of the same point is a design of its own
                key = (key, "again")
            seen.add((key, seed))
            place = places.setdefault(key, len(places))
            if place == len(self.designs):
                self.designs.append([])
            self.designs[place].append(run)
            by_seed.setdefault(seed, {})[place] = run
        self._strata = self._stratified(by_seed)

    def _stratified(self, by_seed: dict[Hashable, dict[int, int]]) -> list[_Stratum]:
        strata: dict[tuple[int, ...], _Stratum] = {}
        for runs in by_seed.values():
            start = 0
            for stop in sorted({self._periods[run] for run in runs.values()}):
                having = {place: run for place, run in runs.items() if self._periods[run] >= stop}
                designs = tuple(sorted(having))
                strata.setdefault(designs, _Stratum(designs, [])).units.append(_Units(having, start, stop))
                start = stop
        return list(strata.values())

    @property
    def is_one_sample(self) -> bool:
        """Whether all periods are interchangeable, and have one number each."""
        return len(self.designs) == 1

    @property
    def can_be_resampled(self) -> bool:
        """Whether no stratum is a single period, which says nothing about its variance."""
        return all(stratum.size > 1 for stratum in self._strata)

    def size(self, design: int) -> int:
        """Return the number of periods of a design."""
        return sum(self._periods[run] for run in self.designs[design])

    def resampled_means(self, runs: Sequence[FloatArray]) -> FloatArray:
        """Return bootstrap samples of the mean over designs: (resamples, …) for runs of (periods, …)."""
        sums = [self._summed(stratum, runs) for stratum in self._strata]
        blocks = [
            np.sum([weights @ total for weights, total in zip(drawn, sums, strict=True)], axis=0)
            for drawn in self._drawn()
        ]
        mean: FloatArray = np.concatenate(blocks) / len(self.designs)
        return mean

    def weights(self) -> Iterator[list[FloatArray]]:
        """Yield the weight of each period of each design in some of the resamples: (resamples, periods) each.

        The periods of a design are in the order of its strata, see `pooled`.
        """
        for drawn in self._drawn():
            designs: list[list[FloatArray]] = [[] for _ in self.designs]
            for stratum, weights in zip(self._strata, drawn, strict=True):
                for design in stratum.designs:
                    designs[design].append(self._share(stratum, design) * weights)
            yield [np.concatenate(parts, axis=1) for parts in designs]

    def pooled(self, design: int, runs: Sequence[NDArray[np.generic]]) -> FloatArray:
        """Return the values of a design, (periods, …), from those of all runs."""
        return np.concatenate([stratum.of(design, runs) for stratum in self._strata if design in stratum.designs])

    def _summed(self, stratum: _Stratum, runs: Sequence[FloatArray]) -> FloatArray:
        """Return the sum over designs of what each period of a stratum contributes to their means."""
        total: FloatArray | None = None
        for design in stratum.designs:
            part = self._share(stratum, design) * stratum.of(design, runs)
            total = part if total is None else total + part
        assert total is not None
        return total

    def _share(self, stratum: _Stratum, design: int) -> float:
        return stratum.size / self.size(design)

    def _drawn(self) -> Iterator[list[FloatArray]]:
        """Yield weights of the periods of each stratum, (resamples, size), until there are `RESAMPLES` of them."""
        sizes = [stratum.size for stratum in self._strata]
        few = sum(sizes) * RESAMPLES <= _CACHED
        if few and all(len(stratum.units) == 1 for stratum in self._strata):
            yield [resample_weights(size, number) for number, size in enumerate(sizes)]
            return
        draw = [np.random.default_rng(number) for number in range(len(sizes))]
        block = max(1, _AT_ONCE // sum(sizes))
        for begin in range(0, RESAMPLES, block):
            count = min(block, RESAMPLES - begin)
            yield [
                rng.multinomial(size, np.full(size, 1 / size), size=count) / size
                for rng, size in zip(draw, sizes, strict=True)
            ]
