"""Effects: the numbers of the parts of a claim under many readings and weightings of the periods at once.

The same parts as those of the ledger, but evaluated from numbers that are kept for every point and measure, since
thousands of specifications share them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, singledispatch
from itertools import product
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis import parts
from rl_design_space.analysis.bounds import Bounds, known, stacked
from rl_design_space.analysis.multiverse.margins import Margin, smallest
from rl_design_space.errors import ConfigError

Where = Mapping[str, Any]


class Source(Protocol):
    """Measured numbers of points under several readings: (readings, 1 + resamples), the measured value first."""

    def one(self, where: Where, measure: Any) -> Bounds:
        """Return a measure of the only point with these values."""
        ...

    def by(self, where: Where, parameter: str, measure: Any) -> Mapping[Any, Bounds]:
        """Return a measure of all points with these values, by their value of another parameter."""
        ...

    def exploration(self, where: Where, parameter: str) -> Mapping[Any, FloatArray]:
        """Return the sum of ε over the trials, (readings,), of all points with these values, by another parameter."""
        ...


@dataclass(frozen=True, eq=False)
class Effect:
    """The numbers of a part, or of several parts that hold together.

    Attributes:
        what: description of the statistic.
        numbers: its values, (readings, 1 + resamples); None if the effect is one of parts.
        low, high: the range.
        placebos: the numbers that other values would have in place of the one that a claim calls the best.
        expected: parameter and value that a claim calls the best; None if it names none.
        parts: effects that this one is made of.
        every: whether all of the parts must hold, or one of them.
    """

    what: str = ""
    numbers: Bounds | None = None
    low: float = -math.inf
    high: float = math.inf
    placebos: Mapping[Any, Bounds] = field(default_factory=dict)
    expected: tuple[str, Any] | None = None
    parts: Sequence[Effect] = ()
    every: bool = True

    @cached_property
    def margin(self) -> Margin:
        """The margin in the range; that of the parts together."""
        if self.numbers is not None:
            return Margin.of(self.numbers, self.low, self.high)
        first, *others = (part.margin for part in self.parts)
        for other in others:
            first = first & other if self.every else first | other
        return first

    @property
    def leaves(self) -> list[Effect]:
        """The parts that have numbers."""
        return [self] if self.numbers is not None else [leaf for part in self.parts for leaf in part.leaves]

    @property
    def decisive(self) -> NDArray[np.intp]:
        """The place of the leaf that decides, (readings,).

        It is the one nearest to its limit or farthest beyond it; of alternatives the best one. Of equals it is the
        first, of equal alternatives the last.
        """
        if self.numbers is not None:
            return np.zeros(len(self.numbers.low), np.intp)
        margins = np.array([part.margin.value for part in self.parts])
        last = len(margins) - 1
        part = margins.argmin(axis=0) if self.every else last - margins[::-1].argmax(axis=0)
        before = np.cumsum([0, *(len(each.leaves) for each in self.parts)])
        inner = np.array([each.decisive for each in self.parts])
        leaf: NDArray[np.intp] = before[part] + np.take_along_axis(inner, part[np.newaxis], axis=0)[0]
        return leaf

    def slots(self) -> Iterator[Effect]:
        """Yield the parts in which another value could stand in place of the claimed best one."""
        if self.placebos:
            yield self
        for part in self.parts:
            yield from part.slots()


@singledispatch
def effect(part: object, source: Source) -> Effect:
    """Return the effect of a part of a claim.

    Raises:
        LookupError: the value that it calls the best is not in the grid.
        ConfigError: it is a part that cannot be evaluated in this way.
    """
    raise ConfigError(f"{type(part).__name__}: a multiverse cannot have this part; it knows those of analysis.parts")


def with_limits(found: Effect, part: Any) -> Effect:
    """Return an effect with the range of another part, which differs from its own in nothing else."""
    if found.numbers is None:
        others = getattr(part, "parts", [part] * len(found.parts))
        return replace(found, parts=[with_limits(*each) for each in zip(found.parts, others, strict=True)])
    low, high = part.range
    return replace(found, low=low, high=high)


def all_of(found: Sequence[Effect]) -> Effect:
    """Return the effect of parts that must all hold."""
    return found[0] if len(found) == 1 else Effect(parts=tuple(found))


@effect.register
def _level(part: parts.Level, source: Source) -> Effect:
    return _ranged(part, source.one(part.point, part.measure))


@effect.register
def _ratio(part: parts.Ratio, source: Source) -> Effect:
    return _ranged(part, source.one(part.point, part.measure).over(source.one(part.to, part.measure)))


@effect.register
def _difference(part: parts.Difference, source: Source) -> Effect:
    return _ranged(part, source.one(part.point, part.measure).minus(source.one(part.to, part.measure)))


@effect.register
def _best_over_best(part: parts.BestOverBest, source: Source) -> Effect:
    ones = source.by(part.among, part.parameter, part.measure)
    others = source.by(part.to, part.to_parameter or part.parameter, part.measure)
    return _ranged(part, smallest(list(ones.values())).over(smallest(list(others.values()))))


@effect.register
def _all_over(part: parts.AllOver, source: Source) -> Effect:
    grid, to = source.by(part.among, part.parameter, part.measure), source.one(part.to, part.measure)
    return Effect(part.what, parts=[_ranged(part, numbers.over(to)) for numbers in grid.values()])


@effect.register
def _typical(part: parts.TypicalOverTypical, source: Source) -> Effect:
    ones = source.by(part.among, part.parameter, part.measure)
    others = source.by(part.to, part.to_parameter or part.parameter, part.measure)
    return _ranged(part, _median(ones).over(_median(others)))


@effect.register
def _joint_ratio(part: parts.JointRatio, source: Source) -> Effect:
    cells = [dict(zip(part.cells, values, strict=True)) for values in product(*part.cells.values())]
    pairs = [[source.one({**cell, **where}, part.measure) for where in (part.point, part.to)] for cell in cells]
    ratios = stacked([one.over(other) for one, other in pairs])
    with np.errstate(divide="ignore"):
        mean = Bounds(np.exp(np.log(ratios.low).mean(axis=0)), np.exp(np.log(ratios.high).mean(axis=0)))
    return _ranged(part, mean)


@effect.register
def _all_parts(part: parts.AllOf, source: Source) -> Effect:
    return Effect(part.what, parts=[effect(each, source) for each in part.parts])


@effect.register
def _any_part(part: parts.AnyOf, source: Source) -> Effect:
    return Effect(part.what, parts=[effect(each, source) for each in part.parts], every=False)


@effect.register(parts.WithinOfAll)
@effect.register(parts.ExpectedOverBest)
def _expected(part: parts.WithinOfAll | parts.ExpectedOverBest, source: Source) -> Effect:
    """Return the effect of the value that is called the best: its measure over the smallest one of the grid."""
    grid = source.by(part.among, part.parameter, part.measure)
    if part.expected not in grid:
        raise LookupError(f"{part.parameter}={part.expected}: there is no such point")
    best = smallest(list(grid.values()))
    over = {value: _at_least_1(numbers.over(best)) for value, numbers in grid.items()}
    claimed = over.pop(part.expected)
    return _ranged(part, claimed, placebos=over, expected=(part.parameter, part.expected))


@effect.register
def _exploration(part: parts.ExplorationOverExploration, source: Source) -> Effect:
    one, other = (_at_best(source, where, part) for where in (part.among, part.to))
    return _ranged(part, one.over(other))


@effect.register
def _known_observations(part: parts.KnownObservations, source: Source) -> Effect:
    value = part.test(cast(parts.Data, source)).value  # exact, from no data
    return _ranged(part, known(np.array([[value, value]])))


def _ranged(part: Any, numbers: Bounds, **more: Any) -> Effect:
    return Effect(part.what, numbers, *part.range, **more)


def _median(grid: Mapping[Any, Bounds]) -> Bounds:
    numbers = stacked(list(grid.values()))
    return Bounds(np.median(numbers.low, axis=0), np.median(numbers.high, axis=0))


def _at_least_1(ratio: Bounds) -> Bounds:
    """Return a ratio to the smallest of some numbers, itself among them, so that it is 1 or more."""
    return Bounds(np.fmax(ratio.low, 1.0), ratio.high)


def _at_best(source: Source, where: Where, part: parts.ExplorationOverExploration) -> Bounds:
    """Return the total exploration at the best schedule, which is selected again under each weighting."""
    grid = source.by(where, part.parameter, part.measure)
    exploration = source.exploration(where, part.parameter)
    chosen = np.argmin([numbers.low for numbers in grid.values()], axis=0)
    each = np.array([exploration[value] for value in grid])
    return known(each[chosen, np.arange(each.shape[1])[:, np.newaxis]])
