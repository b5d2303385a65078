"""Parts about one point, or about two."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import Measure, measured, measured_each, share_ends, weightings
from rl_design_space.analysis.parts.ranged import Choice, Ranged
from rl_design_space.analysis.tested import Tested, never_or_always


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Level(Ranged):
    """A measure of one point.

    Attributes:
        point: values of its parameters.
        measure: as in `learning.measures`.
    """

    point: Choice
    measure: Measure

    def test(self, data: Data) -> Tested:
        recorded = data.one(self.point)
        tested = self._tested(*(measured(self.measure, recorded, weights) for weights in weightings(recorded)))
        ends = share_ends(self.measure, recorded)
        return never_or_always(tested, *ends) if ends else tested


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OfTwo(Ranged):
    """A comparison of a measure of two points.

    Attributes:
        point: values of the parameters of the one point.
        to: values of the parameters of the other point.
        measure: as in `learning.measures`.
    """

    point: Choice
    to: Choice
    measure: Measure

    def test(self, data: Data) -> Tested:
        both = data.one(self.point), data.one(self.to)
        return self._tested(
            *(self._compared(*measured_each(self.measure, both, weights)) for weights in weightings(both[0]))
        )

    def _compared(self, one: Bounds, other: Bounds) -> Bounds:
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Ratio(OfTwo):
    """A measure of one point over that of another; see `OfTwo`."""

    def _compared(self, one: Bounds, other: Bounds) -> Bounds:
        return one.over(other)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Difference(OfTwo):
    """A measure of one point minus that of another; see `OfTwo`."""

    def test(self, data: Data) -> Tested:
        tested = super().test(data)
        one, other = (share_ends(self.measure, data.one(where)) for where in (self.point, self.to))
        return never_or_always(tested, one[0] - other[1], one[1] - other[0]) if one and other else tested

    def _compared(self, one: Bounds, other: Bounds) -> Bounds:
        return one.minus(other)
