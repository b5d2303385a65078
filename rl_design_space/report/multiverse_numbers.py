"""Numbers of a multiverse: every measure of every point that a specification needs, under the same resamples."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.multiverse.effects import Where
from rl_design_space.analysis.parts.measured import measured
from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.measures import CurveMeasure, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.multiverse_points import ReadPoints
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs

#: Resamples of the periods. Fewer than the ledger takes: there are thousands of specifications.
RESAMPLES = 200
#: Results that are held in memory at once.
_AT_ONCE = 64
_NOTHING = np.ones(1)
#: Stands for a parameter in which any two points differ.
_ANY = "fingerprint"


class Numbers:
    """Measures of points, each computed once, from the periods that all points have.

    Args:
        runs: the recorded points.
    """

    def __init__(self, runs: Runs) -> None:
        self._runs = runs
        recorded = [point for point in runs.points if point.run]
        #: Number of periods of each point that count.
        self.periods = min((point.parameters["task.periods"] for point in recorded), default=0)
        self._numbers: dict[tuple[Point, str], Bounds] = {}
        self._exploration: dict[Point, float] = {}

    def compute(self, wanted: Mapping[Point, Iterable[str]]) -> None:
        """Compute measures of points; points without a run are left out."""
        if not self.periods:
            return
        weights = np.concatenate(
            [np.full((1, self.periods), 1 / self.periods), resample_weights(self.periods, 0, RESAMPLES)]
        )
        with ThreadPoolExecutor(available_threads()) as pool:
            recorded = [point for point in wanted if point.run]
            for start in range(0, len(recorded), _AT_ONCE):
                points = recorded[start : start + _AT_ONCE]
                results = [self._result(point) for point in points]
                measures = [sorted(wanted[point]) for point in points]
                numbers = pool.map(_measured, results, measures, [weights] * len(points))
                for point, result, found in zip(points, results, numbers, strict=True):
                    self._exploration[point] = float(result.epsilon.sum())
                    self._numbers.update({(point, name): bounds for name, bounds in found.items()})

    def of(self, point: Point, measure: str) -> Bounds:
        """Return a measure of a point.

        Raises:
            LookupError: the point has no run, or too few trials.
        """
        self._check(point)
        if (point, measure) not in self._numbers:
            raise LookupError(f"{measure}: there are only {point.parameters['task.trials']} trials")
        return self._numbers[point, measure]

    def exploration(self, point: Point) -> float:
        """Return the sum of ε over the trials of a point.

        Raises:
            LookupError: the point has no run.
        """
        self._check(point)
        return self._exploration[point]

    def _check(self, point: Point) -> None:
        if point.run is None:
            raise LookupError(f"missing: {point.planned.command}")

    def _result(self, point: Point) -> LearningCurves:
        result = self._runs.result(point)
        assert result is not None
        self._runs.forget(point)
        return result.of_periods(slice(self.periods))


def _measured(result: LearningCurves, names: Sequence[str], weights: FloatArray) -> dict[str, Bounds]:
    """Return measures of a point; those of a curve share it, as resampled median curves take the most time."""
    curves: dict[str, FloatArray] = {}
    found = {}
    for name in names:
        of = measure(name)
        if isinstance(of, CurveMeasure):
            if (statistic := of.statistic).name not in curves:
                curves[statistic.name] = statistic.of(result.over_optimum, weights)
            samples = of.of(curves[statistic.name])
            never = of.censored_at(result)
            found[name] = Bounds(samples, samples if never is None else np.where(samples >= never, np.inf, samples))
        else:
            with suppress(LookupError):  # too few trials for it, as in a quick look
                found[name] = measured(name, result, weights)
    return found


class Asked:
    """A source of effects that notes which measures of which points are asked for, and knows none of them.

    Args:
        points: all points.
    """

    def __init__(self, points: ReadPoints) -> None:
        self._points = points
        self.noted: dict[tuple[Hashable, str], None] = {}

    def one(self, where: Where, measure: Any) -> Bounds:
        self.noted[self._points.one(where), measure] = None
        return Bounds(_NOTHING, _NOTHING)

    def by(self, where: Where, parameter: str, measure: Any) -> Mapping[Any, Bounds]:
        found = by_value(self._points, where, parameter)
        self.noted.update({(base, measure): None for base in found.values()})
        return {value: Bounds(_NOTHING, _NOTHING) for value in found}

    def exploration(self, where: Where, parameter: str) -> Mapping[Any, float]:
        return dict.fromkeys(by_value(self._points, where, parameter), 1.0)


class UnderReading:
    """A source of effects under one reading.

    Args:
        points: all points.
        numbers: their measures.
        reading: numbers of its alternatives.
    """

    def __init__(self, points: ReadPoints, numbers: Numbers, reading: Iterable[int]) -> None:
        self._points = points
        self._numbers = numbers
        self._reading = tuple(reading)

    def one(self, where: Where, measure: Any) -> Bounds:
        return self._numbers.of(self._read(self._points.one(where)), measure)

    def by(self, where: Where, parameter: str, measure: Any) -> Mapping[Any, Bounds]:
        return {value: self._numbers.of(point, measure) for value, point in self._each(where, parameter)}

    def exploration(self, where: Where, parameter: str) -> Mapping[Any, float]:
        return {value: self._numbers.exploration(point) for value, point in self._each(where, parameter)}

    def _each(self, where: Where, parameter: str) -> Iterator[tuple[Any, Point]]:
        return ((value, self._read(base)) for value, base in by_value(self._points, where, parameter).items())

    def _read(self, base: Hashable) -> Point:
        return self._points.read(base, self._reading)


def by_value(points: ReadPoints, where: Where, parameter: str) -> dict[Any, Hashable]:
    """Return the points of the decided reading that have these values, by their value of another parameter."""
    found = points.where(where)
    return {base if parameter == _ANY else points.bases[base].parameters[parameter]: base for base in found}
