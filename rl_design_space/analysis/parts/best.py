"""Parts about best points that are selected on the even-numbered periods and compared on the odd-numbered ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts.claimed_best import ClaimedBest
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import (
    EVEN,
    ODD,
    Cost,
    at_the_edge,
    measured,
    measured_each,
    value,
    weightings,
)
from rl_design_space.analysis.parts.ranged import Choice, Ranged, Text
from rl_design_space.analysis.tested import Severity, Tested
from rl_design_space.learning.result import LearningCurves


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ExpectedOverBest(ClaimedBest):
    """A measure at the claimed best value of a parameter, over that at the measured best value.

    See `ClaimedBest`.
    """

    def test(self, data: Data) -> Tested:
        points = self.grid(data)
        best = _best(points, self.measure)
        weighted = weightings(points[best], ODD)
        both = [measured_each(self.measure, list(points.values()), weights) for weights in weighted]
        measures = dict(zip(points, zip(*both, strict=True), strict=True))
        tested = {
            key: self._tested(*(one.over(other) for one, other in zip(each, measures[best], strict=True)))
            for key, each in measures.items()
        }
        others = [key for key in points if key != self.expected]
        expected = tested[self.expected]
        severity = Severity(
            passing=sum(tested[key].state == "holds" for key in others),
            others=len(others),
            is_near=self._is_near(expected),
            others_near=sum(self._is_near(tested[key]) for key in others),
        )
        remarks = (*expected.remarks, *at_the_edge(self.parameter, points, best))
        return replace(expected, severity=severity, remarks=remarks)

    def _is_near(self, tested: Tested) -> bool:
        low, high = self.range
        return low <= tested.value <= high


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BestOverBest(Ranged):
    """A measure of the best of some points over that of the best of others.

    Attributes:
        among: values that the first points have in common.
        parameter: parameter in which they differ.
        to: values that the other points have in common.
        to_parameter: parameter in which those differ; `parameter` if left out.
        measure: as in `learning.measures`; the smallest is the best.
    """

    among: Choice
    parameter: Text
    to: Choice
    to_parameter: Text | None = None
    measure: Cost

    def test(self, data: Data) -> Tested:
        to_parameter = self.to_parameter or self.parameter
        ones, others = data.by(self.among, self.parameter), data.by(self.to, to_parameter)
        best, to_best = _best(ones, self.measure), _best(others, self.measure)
        one, other = ones[best], others[to_best]
        tested = self._tested(
            *(
                measured(self.measure, one, weights).over(measured(self.measure, other, weights))
                for weights in weightings(one, ODD)
            )
        )
        edges = (*at_the_edge(self.parameter, ones, best), *at_the_edge(to_parameter, others, to_best))
        return replace(tested, remarks=tuple(dict.fromkeys((*tested.remarks, *edges))))


def _best(points: Mapping[Any, LearningCurves], name: str) -> Any:
    """Return the value of a parameter with the smallest measure on the even-numbered periods."""
    return min(points, key=lambda each: value(name, points[each], EVEN))
