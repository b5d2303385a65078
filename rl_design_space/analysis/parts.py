"""Parts of claims: statistics of the periods of points, each with the range that a claim gives for it.

The unit is the period. Points of equal size have the same layouts, so all of them are resampled with the same weights.
A best point is selected on the even-numbered periods and compared on the odd-numbered ones.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Protocol

import numpy as np
from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.claims import Tested, exact, in_range
from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.design import Representation, Torus, World, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import ALIASES, MEASURES, measure
from rl_design_space.learning.result import LearningCurves

Where = dict[str, Any]
EVEN, ODD = slice(0, None, 2), slice(1, None, 2)


class Data(Protocol):
    """Recorded points by the values of their parameters."""

    def one(self, where: Where) -> LearningCurves:
        """Return the only point with these values.

        Raises:
            LookupError: it has not been recorded.
        """
        ...

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        """Return all points with these values, by their value of another parameter.

        Raises:
            LookupError: one of them has not been recorded.
        """
        ...


class Part(Protocol):
    """A part of a claim."""

    def test(self, data: Data) -> Tested:
        """Test this part on recorded data.

        Raises:
            LookupError: a point that it needs has not been recorded.
        """
        ...


def _known_measure(name: str) -> str:
    if name not in (*MEASURES, *ALIASES):
        raise ValueError(f"should be among {', '.join(MEASURES)}")
    return name


Measure = Annotated[str, AfterValidator(_known_measure)]
Text = Annotated[str, Field(min_length=1)]
_Choice = Annotated[Where, Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _Ranged:
    """Base of all parts: a description and a range.

    Attributes:
        what: description of the statistic.
        low: lower end of the range; none if left out.
        high: upper end of the range; none if left out.
    """

    what: Text
    low: float | None = None
    high: float | None = None

    def _tested(self, value: FloatArray, samples: FloatArray) -> Tested:
        low, high = self._range
        return in_range(self.what, float(value[0]), samples, low, high)

    @property
    def _range(self) -> tuple[float, float]:
        return (-math.inf if self.low is None else self.low, math.inf if self.high is None else self.high)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Level(_Ranged):
    """A measure of one point.

    Attributes:
        point: values of its parameters.
        measure: name in `learning.measures`.
    """

    point: _Choice
    measure: Measure

    def test(self, data: Data) -> Tested:
        recorded = data.one(self.point)
        return self._tested(*(_samples(self.measure, recorded, weights) for weights in _weights(recorded)))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _OfTwo(_Ranged):
    """A comparison of a measure of two points.

    Attributes:
        point: values of the parameters of the one point.
        to: values of the parameters of the other point.
        measure: name in `learning.measures`.
    """

    point: _Choice
    to: _Choice
    measure: Measure

    def test(self, data: Data) -> Tested:
        one, other = data.one(self.point), data.one(self.to)
        return self._tested(*(self._compared(one, other, weights) for weights in _weights(one)))

    def _compared(self, one: LearningCurves, other: LearningCurves, weights: FloatArray) -> FloatArray:
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Ratio(_OfTwo):
    """A measure of one point over that of another; see `_OfTwo`."""

    def _compared(self, one: LearningCurves, other: LearningCurves, weights: FloatArray) -> FloatArray:
        return _over(self.measure, one, other, weights)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Difference(_OfTwo):
    """A measure of one point minus that of another; see `_OfTwo`."""

    def _compared(self, one: LearningCurves, other: LearningCurves, weights: FloatArray) -> FloatArray:
        return _samples(self.measure, one, weights) - _samples(self.measure, other, weights)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ExpectedOverBest(_Ranged):
    """A measure at the claimed best value of a parameter, over that at the measured best value.

    Attributes:
        among: values that all the points have in common.
        parameter: parameter in which they differ.
        expected: the claimed best value.
        measure: name in `learning.measures`; the smallest is the best.
    """

    among: _Choice
    parameter: Text
    expected: Any
    measure: Measure

    def test(self, data: Data) -> Tested:
        points = data.by(self.among, self.parameter)
        if self.expected not in points:
            raise LookupError(f"{self.parameter}={self.expected}: there is no such point")
        expected, best = points[self.expected], points[_best(points, self.measure)]
        ratios = (_over(self.measure, expected, best, w) for w in _weights(best, ODD))
        return self._tested(*ratios)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class BestOverBest(_Ranged):
    """A measure of the best of some points over that of the best of others.

    Attributes:
        among: values that the first points have in common.
        parameter: parameter in which they differ.
        to: values that the other points have in common.
        to_parameter: parameter in which those differ; `parameter` if left out.
        measure: name in `learning.measures`; the smallest is the best.
    """

    among: _Choice
    parameter: Text
    to: _Choice
    to_parameter: Text | None = None
    measure: Measure

    def test(self, data: Data) -> Tested:
        ones, others = data.by(self.among, self.parameter), data.by(self.to, self.to_parameter or self.parameter)
        one, other = ones[_best(ones, self.measure)], others[_best(others, self.measure)]
        ratios = (_over(self.measure, one, other, w) for w in _weights(one, ODD))
        return self._tested(*ratios)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ExplorationOverExploration(_Ranged):
    """Total exploration (the sum of ε over the trials) at the best schedule of some points over that of others.

    The best schedule is selected again in every resample, so the interval includes the uncertainty of the selection.

    Attributes:
        among: values that the first points have in common.
        to: values that the other points have in common.
        parameter: parameter of the schedule, in which they differ.
        measure: name in `learning.measures`; the smallest is the best.
    """

    among: _Choice
    to: _Choice
    parameter: Text
    measure: Measure

    def test(self, data: Data) -> Tested:
        ones, others = data.by(self.among, self.parameter), data.by(self.to, self.parameter)
        some = next(iter(ones.values()))
        return self._tested(*(self._exploration(ones, w) / self._exploration(others, w) for w in _weights(some)))

    def _exploration(self, points: Mapping[Any, LearningCurves], weights: FloatArray) -> FloatArray:
        measures = np.array([_samples(self.measure, recorded, weights) for recorded in points.values()])
        exploration = np.array([recorded.epsilon.sum() for recorded in points.values()])
        chosen: FloatArray = exploration[measures.argmin(axis=0)]
        return chosen


@dataclass(frozen=True, kw_only=True, config=STRICT)
class KnownObservations(_Ranged):
    """Share of the observations of a world that a smaller one has as well, over all layouts with one goal; exact.

    Attributes:
        representation: an option, e.g. `{_target_: rl_design_space.design.Direction}`.
        sizes: sizes of the smaller and of the larger world.
    """

    representation: Representation
    sizes: Annotated[tuple[int, int], Field(strict=False)]

    def test(self, data: Data) -> Tested:
        known, met = (self._observations(Torus(size=size)) for size in self.sizes)
        return exact(self.what, len(met & known) / len(met), *self._range)

    def _observations(self, world: World) -> set[int]:
        goals = np.arange(cell_count(world))[:, np.newaxis]
        return set(np.unique(self.representation.observation(world, goals)).tolist())


def _samples(name: str, recorded: LearningCurves, weights: FloatArray) -> FloatArray:
    """Return a measure of a point under each weighting of the periods.

    Raises:
        ConfigError: the weights are those of points with another number of periods.
    """
    if len(recorded.steps) != weights.shape[1]:
        raise ConfigError(
            f"seed, task.periods: points of {weights.shape[1]} and {len(recorded.steps)} periods cannot be compared in "
            "pairs; a claim needs points with the same seeds and numbers of periods"
        )
    return measure(name).samples(recorded, weights)


def _over(name: str, one: LearningCurves, other: LearningCurves, weights: FloatArray) -> FloatArray:
    """Return a measure of one point over that of another; NaN where both are 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio: FloatArray = _samples(name, one, weights) / _samples(name, other, weights)
    return ratio


def _best(points: Mapping[Any, LearningCurves], name: str) -> Any:
    """Return the value of a parameter with the smallest measure on the even-numbered periods."""
    return min(points, key=lambda value: _value(name, points[value]))


def _value(name: str, recorded: LearningCurves) -> float:
    return float(measure(name).samples(recorded, _equal(len(recorded.steps), EVEN))[0])


def _weights(recorded: LearningCurves, half: slice | None = None) -> tuple[FloatArray, FloatArray]:
    """Return equal weights of the periods, and weights of resamples; 0 outside of `half` if it is given."""
    periods = len(recorded.steps)
    if half is None:
        return _equal(periods, slice(None)), resample_weights(periods)
    chosen = np.arange(periods)[half]
    resampled = np.zeros((0, 0)) if not len(chosen) else resample_weights(len(chosen))
    weights = np.zeros((len(resampled), periods))
    weights[:, chosen] = resampled
    return _equal(periods, half), weights


def _equal(periods: int, half: slice) -> FloatArray:
    weights = np.zeros((1, periods))
    weights[:, half] = 1.0
    equal: FloatArray = weights / weights.sum()
    return equal
