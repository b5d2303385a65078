"""Recorded points for the parts of claims."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.points import Point, by_design
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.selection import Where

#: Stands for a parameter in which any two points differ.
ANY = "fingerprint"


class RecordedPoints:
    """Points of the parts of claims, see `analysis.parts.Data`.

    Args:
        runs: the points there are.
        common: values of parameters that all points have unless a part says otherwise.
        reading: values of parameters that a point has if it has such a parameter at all.
    """

    def __init__(self, runs: Runs, common: Where, reading: Where) -> None:
        self._runs = runs.under(reading)
        self._common = common
        #: Numbers of periods of the points that were asked for.
        self.periods: set[int] = set()

    def one(self, where: Where) -> LearningCurves:
        return self._result(self._runs.seeds({**self._common, **where}))

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        return {value: self._result(seeds) for value, seeds in self.grouped(where, parameter).items()}

    def grouped(self, where: Where, parameter: str) -> Mapping[Any, Sequence[Point]]:
        """Return all points with these values, recorded or not, by their value of another parameter.

        Raises:
            LookupError: there is none.
        """
        values: dict[Any, list[Point]] = {}
        found = self._runs.where({**self._common, **where})
        if not found:
            wanted = " ".join(f"{name}={value}" for name, value in where.items())
            raise LookupError(f"no point of these studies has {wanted}")
        for seeds in by_design(found):
            value = seeds[0].planned.fingerprint if parameter == ANY else seeds[0].parameters[parameter]
            values.setdefault(value, []).extend(seeds)
        return values

    def forget(self) -> None:
        """Free the memory of all results."""
        for point in self._runs.points:
            self._runs.forget(point)

    def _result(self, seeds: Sequence[Point]) -> LearningCurves:
        result = self._runs.pooled(seeds)
        if result is None:
            missing = next((point for point in seeds if point.run is None), seeds[0])
            raise LookupError(f"missing: {missing.planned.command}")
        self.periods.add(len(result.steps))
        return result


class LargerSamples(RecordedPoints):
    """Larger samples of the points of parts of claims.

    Args:
        runs: the larger samples.
        common, reading: see `RecordedPoints`.
        of: the points that they are samples of.
    """

    def __init__(self, runs: Runs, common: Where, reading: Where, of: RecordedPoints) -> None:
        super().__init__(runs, common, reading)
        self._of = of

    def one(self, where: Where) -> LearningCurves:
        self._find(where)
        return super().one(where)

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        self._find(where)
        found = self.grouped(where, parameter)
        if len(found) < len(self._of.grouped(where, parameter)):
            raise LookupError("not every point has a larger sample")
        return super().by(where, parameter)

    def _find(self, where: Where) -> None:
        """Check that there is a larger sample.

        Raises:
            LookupError: there is none.
        """
        if not self._runs.where({**self._common, **where}):
            raise LookupError("there is no larger sample")
