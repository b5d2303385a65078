"""Numbers of a multiverse: every measure of every point that a specification needs, under the same resamples."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds, known, stacked
from rl_design_space.analysis.multiverse.effects import Where
from rl_design_space.analysis.parts.measured import has_trials, measured
from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.measure_statistics import Statistic
from rl_design_space.learning.measures import CurveMeasure, PeriodMeasure, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.multiverse_points import Base, ReadPoints
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs

#: Resamples of the periods. Fewer than the ledger takes: there are thousands of specifications.
RESAMPLES = 200
#: Results that are held in memory at once.
_AT_ONCE = 64
#: Stands for the numbers of a point under one reading.
_NOTHING = np.ones((1, 1))
#: Size of a product of matrices, rows by columns by what is summed up, up to which linear algebra uses one thread.
_ONE_THREAD = 260_000
#: Stands for the columns of a curve, one for each trial.
_CURVE = ""
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
    """Return measures of a point, without those that it has too few trials for.

    Resampled medians take the most time, less if those of all columns, trials of a curve and numbers of periods, are
    found at once.
    """
    measures = {name: measure(name) for name in names if has_trials(name, result)}
    columns: dict[Statistic, dict[str, FloatArray]] = {}
    for name, of in measures.items():
        if isinstance(of, CurveMeasure):
            columns.setdefault(of.statistic, {})[_CURVE] = result.over_optimum
        elif isinstance(of, PeriodMeasure) and not of.statistic.is_mean:
            columns.setdefault(of.statistic, {})[name] = of.of(result)[:, np.newaxis]
    samples = {statistic: _samples(statistic, of, weights) for statistic, of in columns.items()}
    found = {}
    for name, of in measures.items():
        if isinstance(of, CurveMeasure):
            numbers = of.of(samples[of.statistic][_CURVE])
            never = of.censored_at(result)
            found[name] = Bounds(numbers, numbers if never is None else np.where(numbers >= never, np.inf, numbers))
        elif isinstance(of, PeriodMeasure) and not of.statistic.is_mean:
            found[name] = known(samples[of.statistic][name][:, 0])
        else:
            found[name] = measured(name, result, weights)
    return found


def _samples(statistic: Statistic, columns: Mapping[str, FloatArray], weights: FloatArray) -> dict[str, FloatArray]:
    """Return a statistic of each column, in blocks that are too small for linear algebra to start threads for.

    There is a thread for each core already, and more of them would wait for each other.
    """
    values = np.concatenate(list(columns.values()), axis=1)
    rows = max(1, _ONE_THREAD // values.size) if statistic.is_mean else len(weights)
    found = np.concatenate(
        [statistic.of(values, block) for block in np.split(weights, range(rows, len(weights), rows))]
    )
    ends = np.cumsum([each.shape[1] for each in columns.values()])[:-1]
    return dict(zip(columns, np.split(found, ends, axis=1), strict=True))


class Asked:
    """A source of effects that notes which measures of which points are asked for, and knows none of them.

    Args:
        points: all points.
    """

    def __init__(self, points: ReadPoints) -> None:
        self._points = points
        self.noted: dict[tuple[Base, str], None] = {}

    def one(self, where: Where, measure: Any) -> Bounds:
        self.noted[self._points.one(where), measure] = None
        return Bounds(_NOTHING, _NOTHING)

    def by(self, where: Where, parameter: str, measure: Any) -> Mapping[Any, Bounds]:
        found = by_value(self._points, where, parameter)
        self.noted.update({(base, measure): None for base in found.values()})
        return {value: Bounds(_NOTHING, _NOTHING) for value in found}

    def exploration(self, where: Where, parameter: str) -> Mapping[Any, FloatArray]:
        return dict.fromkeys(by_value(self._points, where, parameter), _NOTHING[0])


class UnderReadings:
    """A source of effects under several readings at once.

    Args:
        points: all points.
        numbers: their measures.
        read: the points as each reading changes them.
    """

    def __init__(self, points: ReadPoints, numbers: Numbers, read: Sequence[Mapping[Base, Point]]) -> None:
        self._points = points
        self._numbers = numbers
        self._read = read

    def one(self, where: Where, measure: Any) -> Bounds:
        return self._of(self._points.one(where), measure)

    def by(self, where: Where, parameter: str, measure: Any) -> Mapping[Any, Bounds]:
        return {value: self._of(base, measure) for value, base in by_value(self._points, where, parameter).items()}

    def exploration(self, where: Where, parameter: str) -> Mapping[Any, FloatArray]:
        found = by_value(self._points, where, parameter)
        return {
            value: np.array([self._numbers.exploration(read[base]) for read in self._read])
            for value, base in found.items()
        }

    def _of(self, base: Base, measure: str) -> Bounds:
        return stacked([self._numbers.of(read[base], measure) for read in self._read])


def by_value(points: ReadPoints, where: Where, parameter: str) -> dict[Any, Base]:
    """Return the points of the decided reading that have these values, by their value of another parameter."""
    found = points.where(where)
    return {base if parameter == _ANY else points.bases[base].parameters[parameter]: base for base in found}
