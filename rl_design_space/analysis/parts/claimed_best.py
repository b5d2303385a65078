"""The base of parts about a value that is claimed to be the best of a grid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import Cost
from rl_design_space.analysis.parts.ranged import Choice, Ranged, Text
from rl_design_space.learning.result import LearningCurves


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ClaimedBest(Ranged):
    """A grid of points, and the value of a parameter that is claimed to be the best.

    Attributes:
        among: values that all the points have in common.
        parameter: parameter in which they differ.
        expected: the claimed best value.
        measure: as in `learning.measures`; the smallest is the best.
    """

    among: Choice
    parameter: Text
    expected: Any
    measure: Cost

    def grid(self, data: Data) -> Mapping[Any, LearningCurves]:
        """Return the points by their value of the parameter.

        Raises:
            LookupError: the claimed value is not among them, or one of them has not been recorded.
        """
        points = data.by(self.among, self.parameter)
        if self.expected not in points:
            raise LookupError(f"{self.parameter}={self.expected}: there is no such point")
        return points
