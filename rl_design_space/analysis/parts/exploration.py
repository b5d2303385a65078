"""Parts about the exploration that the best schedules need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.bounds import known
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import Cost, Weights, at_the_edge, measured_each, weightings
from rl_design_space.analysis.parts.ranged import Choice, Ranged, Text
from rl_design_space.analysis.tested import Tested
from rl_design_space.learning.result import LearningCurves


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ExplorationOverExploration(Ranged):
    """Total exploration (the sum of ε over the trials) at the best schedule of some points over that of others.

    The best schedule is selected again in every resample, so the interval includes the uncertainty of the selection.

    Attributes:
        among: values that the first points have in common.
        to: values that the other points have in common.
        parameter: parameter of the schedule, in which they differ.
        measure: as in `learning.measures`; the smallest is the best.
    """

    among: Choice
    to: Choice
    parameter: Text
    measure: Cost

    def test(self, data: Data) -> Tested:
        ones, others = data.by(self.among, self.parameter), data.by(self.to, self.parameter)
        plain, resampled = weightings(next(iter(ones.values())))
        best, to_best = self._best(ones, plain), self._best(others, plain)
        value = _exploration(ones, best) / _exploration(others, to_best)
        samples = _exploration(ones, self._best(ones, resampled)) / _exploration(others, self._best(others, resampled))
        edges = (
            *at_the_edge(self.parameter, ones, list(ones)[best[0]]),
            *at_the_edge(self.parameter, others, list(others)[to_best[0]]),
        )
        tested = self._tested(known(value), known(samples))
        return replace(tested, remarks=tuple(dict.fromkeys((*tested.remarks, *edges))))

    def _best(self, points: Mapping[Any, LearningCurves], weights: Weights) -> NDArray[np.intp]:
        """Return the place of the best point under each weighting of the periods."""
        each = measured_each(self.measure, list(points.values()), weights)
        best: NDArray[np.intp] = np.argmin([bounds.low for bounds in each], axis=0)
        return best


def _exploration(points: Mapping[Any, LearningCurves], chosen: NDArray[np.intp]) -> FloatArray:
    exploration: FloatArray = np.array([each.epsilon.sum() for each in points.values()])[chosen]
    return exploration
