"""Parts about several cells of a table at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.bounds import Bounds, stacked
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.measured import Measure, measured, weightings
from rl_design_space.analysis.parts.ranged import Choice, Ranged
from rl_design_space.analysis.statistics import Resamples
from rl_design_space.analysis.tested import Tested
from rl_design_space.learning.result import LearningCurves

_Values = Annotated[list[Any], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class JointRatio(Ranged):
    """The geometric mean over cells of a measure of one point over that of another.

    A range around 1 is an equivalence bound: the two are as good as equal if the interval of the mean lies in it. Of
    the paper's own numbers, the geometric mean counts.

    Attributes:
        point: values of the parameters of the one point, but for those of the cells.
        to: values of the parameters of the other point.
        cells: values of each parameter of the table; every combination is a cell.
        measure: as in `learning.measures`.
    """

    point: Choice
    to: Choice
    cells: Annotated[dict[str, _Values], Field(min_length=1)]
    measure: Measure

    def refused(self) -> tuple[float, ...]:
        low, high = self.range
        mean = float(np.exp(np.mean(np.log(self.paper)))) if self.paper else None
        return () if mean is None or low <= mean <= high else (mean,)

    def test(self, data: Data) -> Tested:
        ratios = [self._ratios(data.one(one), data.one(other)) for one, other in self._pairs()]
        value, samples = (_geometric_mean(stacked(list(each))) for each in zip(*ratios, strict=True))
        single = [float(plain.low[0]) for plain, _ in ratios]
        spread = f"single cells from {min(single):.3g} to {max(single):.3g}"
        tested = self._tested(value, samples)
        return replace(tested, remarks=(*tested.remarks, spread))

    def _pairs(self) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        for values in product(*self.cells.values()):
            cell = dict(zip(self.cells, values, strict=True))
            yield {**cell, **self.point}, {**cell, **self.to}

    def _ratios(self, one: LearningCurves, other: LearningCurves) -> tuple[Bounds, Bounds]:
        """Return the ratio in a cell, and in each resample; points with other numbers of periods are not paired."""
        plain, resampled = weightings(one)
        to_plain, to_resampled = plain, resampled
        if (periods := len(other.steps)) != len(one.steps):
            to_plain, to_resampled = weightings(other)[0], Resamples(periods, seed=1)
        return (
            measured(self.measure, one, plain).over(measured(self.measure, other, to_plain)),
            measured(self.measure, one, resampled).over(measured(self.measure, other, to_resampled)),
        )


def _geometric_mean(ratios: Bounds) -> Bounds:
    with np.errstate(divide="ignore"):
        return Bounds(np.exp(np.log(ratios.low).mean(axis=0)), np.exp(np.log(ratios.high).mean(axis=0)))
