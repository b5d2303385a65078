"""Parts about all points of a grid at once; nothing is selected, so no periods are set apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.bounds import Bounds, stacked
from rl_design_space.analysis.parts.claimed_best import ClaimedBest
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import Measure, Weights, at_the_edge, measured, measured_each, weightings
from rl_design_space.analysis.parts.ranged import Choice, Ranged, Text
from rl_design_space.analysis.tested import Severity, Tested, every_in_range, interval
from rl_design_space.learning.result import LearningCurves


@dataclass(frozen=True, kw_only=True, config=STRICT)
class WithinOfAll(ClaimedBest):
    """A measure at the claimed best value of a parameter, over that at every other value of the grid.

    With `high: 1.05` the claimed value is within 5 % of the best, whichever that is: each ratio must have its upper
    bound in the range. The value shown is the ratio that decides, and the severity counts the other values of the grid
    that would have passed.

    See `ClaimedBest`.
    """

    def test(self, data: Data) -> Tested:
        points = self.grid(data)
        if len(points) == 1:
            raise LookupError(f"{self.parameter}={self.expected}: there is no other value to compare it with")
        plain, resampled = _of_grid(self.measure, points)
        values = list(points)
        place = values.index(self.expected)
        value, samples = _over_others(plain, place), _over_others(resampled, place)
        tested, decisive = every_in_range(self.what, value, samples, *self.range)
        others = [other for other in range(len(values)) if other != place]
        severity = Severity(
            passing=sum(self._passes(_over_others(resampled, other)) for other in others),
            others=len(others),
            is_near=self._is_near(value),
            others_near=sum(self._is_near(_over_others(plain, other)) for other in others),
        )
        best = values[int(plain.low[:, 0].argmin())]
        remarks = (
            f"decided by {self.parameter} = {values[others[decisive]]}",
            *at_the_edge(self.parameter, points, best),
            *(at_the_edge(self.parameter, points, self.expected, "claimed value") if best != self.expected else ()),
        )
        return replace(tested, severity=severity, remarks=remarks)

    def _passes(self, ratios: Bounds) -> bool:
        """Return whether each ratio has its interval in the range."""
        low, high = self.range
        ends = [interval(ratios.row(index)) for index in range(len(ratios.low))]
        return all(low <= end[0] and end[1] <= high for end in ends)

    def _is_near(self, ratios: Bounds) -> bool:
        """Return whether each ratio is in the range."""
        low, high = self.range
        return bool(((low <= ratios.low) & (ratios.high <= high)).all())


@dataclass(frozen=True, kw_only=True, config=STRICT)
class AllOver(Ranged):
    """A measure of every point of a grid over that of one point; each ratio must lie in the range.

    The value shown is the ratio that decides.

    Attributes:
        among: values that the points of the grid have in common.
        parameter: parameter in which they differ; `fingerprint` if they differ in several.
        to: values of the parameters of the one point.
        measure: as in `learning.measures`.
    """

    among: Choice
    parameter: Text
    to: Choice
    measure: Measure

    def test(self, data: Data) -> Tested:
        points, to = data.by(self.among, self.parameter), data.one(self.to)
        (ones, resampled), (plain, resamples) = _of_grid(self.measure, points), weightings(to)
        value = ones.over(measured(self.measure, to, plain))
        samples = resampled.over(measured(self.measure, to, resamples))
        tested, decisive = every_in_range(self.what, value, samples, *self.range)
        shown = () if self.parameter == "fingerprint" else (f"decided by {self.parameter} = {list(points)[decisive]}",)
        return replace(tested, remarks=shown)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TypicalOverTypical(Ranged):
    """The median over the points of a grid of a measure, over the median over those of another grid.

    It compares what is usual in the two grids rather than the best that they have.

    Attributes:
        among: values that the first points have in common.
        parameter: parameter in which they differ; `fingerprint` if they differ in several.
        to: values that the other points have in common.
        to_parameter: parameter in which those differ; `parameter` if left out.
        measure: as in `learning.measures`.
    """

    among: Choice
    parameter: Text
    to: Choice
    to_parameter: Text | None = None
    measure: Measure

    def test(self, data: Data) -> Tested:
        ones, others = data.by(self.among, self.parameter), data.by(self.to, self.to_parameter or self.parameter)
        medians = [[_median(each) for each in _of_grid(self.measure, points)] for points in (ones, others)]
        return self._tested(*(one.over(other) for one, other in zip(*medians, strict=True)))


def _of_grid(name: str, points: Mapping[Any, LearningCurves]) -> tuple[Bounds, Bounds]:
    """Return a measure of all points, (points, 1), and in each resample, (points, resamples)."""
    plain, resampled = weightings(next(iter(points.values())))
    return _rows(name, points, plain), _rows(name, points, resampled)


def _rows(name: str, points: Mapping[Any, LearningCurves], weights: Weights) -> Bounds:
    return stacked(measured_each(name, list(points.values()), weights))


def _over_others(measures: Bounds, place: int) -> Bounds:
    """Return the ratios of one row to all others."""
    others = Bounds(np.delete(measures.low, place, axis=0), np.delete(measures.high, place, axis=0))
    return measures.row(place).over(others)


def _median(measures: Bounds) -> Bounds:
    return Bounds(np.median(measures.low, axis=0), np.median(measures.high, axis=0))
