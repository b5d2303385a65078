"""Measures of recorded points under weightings of their periods.

The unit is the period. Points of equal size have the same layouts, so all of them are resampled with the same weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import AfterValidator

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.censoring import Censored
from rl_design_space.analysis.statistics import Resamples, share_estimate
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_spec import parsed
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves

_NOTHING = Censored(np.zeros(0), np.zeros(0, bool), np.zeros(0, bool))
EVEN, ODD = slice(0, None, 2), slice(1, None, 2)


def _smallest_is_best(name: str) -> str:
    if measure(name).largest_is_best:
        raise ValueError("the largest value of this measure is the best; should be one of which the smallest is")
    return name


Measure: TypeAlias = MeasureName
#: A measure whose smallest value is the best.
Cost = Annotated[MeasureName, AfterValidator(_smallest_is_best)]


#: Weightings of periods: (weightings, periods), or resamples.
Weights: TypeAlias = FloatArray | Resamples


def measured(name: str, recorded: LearningCurves, weights: Weights) -> Bounds:
    """Return a measure of a point under each weighting of the periods, see `measured_each`."""
    return measured_each(name, [recorded], weights)[0]


def measured_each(name: str, points: Sequence[LearningCurves], weights: Weights) -> list[Bounds]:
    """Return a measure of points under each weighting of the periods.

    Under resamples it is computed once for each result, because several parts of claims ask for it. Of many periods,
    the weights take longer to make than to use, so each block of them serves all points.

    Raises:
        ConfigError: the weights are those of points with another number of periods.
        LookupError: a point has too few trials for this measure, as in a quick look.
    """
    for recorded in points:
        _check(name, recorded, weights)
    if not isinstance(weights, Resamples):
        return [_bounds([each]) for each in Censored.of_each(measure(name), points, weights)]
    key = name, weights
    new = [recorded for recorded in points if key not in recorded.computed]
    parts: list[list[Censored]] = [[] for _ in new]
    for block in weights.blocks() if new else ():
        for part, each in zip(parts, Censored.of_each(measure(name), new, block), strict=True):
            part.append(each)
    for recorded, part in zip(new, parts, strict=True):
        recorded.computed[key] = _bounds(part)
    return [recorded.computed[key] for recorded in points]


def _check(name: str, recorded: LearningCurves, weights: Weights) -> None:
    if len(recorded.steps) != weights.shape[1]:
        raise ConfigError(
            f"seed, task.periods: points of {weights.shape[1]} and {len(recorded.steps)} periods cannot be compared in "
            "pairs; a claim needs points with the same seeds and numbers of periods"
        )
    if not has_trials(name, recorded):
        raise LookupError(f"{name}: there are only {recorded.steps.shape[1]} trials")


def _bounds(parts: Sequence[Censored]) -> Bounds:
    found = parts[0] if len(parts) == 1 else Censored.joined(parts or [_NOTHING])
    samples = found.values
    return Bounds(samples, np.where(found.at_least, np.inf, samples) if found.at_least.any() else samples)


def has_trials(name: str, recorded: LearningCurves) -> bool:
    """Return whether a point has enough trials for a measure."""
    spec = parsed(name)
    return spec.name != "steps_after" or spec.value is None or spec.value < recorded.steps.shape[1]


def share_ends(name: str, recorded: LearningCurves) -> tuple[float, float] | None:
    """Return the ends of the Wilson interval of a share that is 0 or 1 in every period; None of any other measure."""
    found = measure(name)
    values = found.each(recorded) if found.meaning.startswith("share of") else None
    if values is None or not ((values == 0).all() or (values == 1).all()):
        return None
    _, low, high = share_estimate(values.astype(bool))
    return low, high


def value(name: str, recorded: LearningCurves, half: slice = slice(None)) -> float:
    """Return a measure of a point on all or some of its periods."""
    return float(measured(name, recorded, equal(len(recorded.steps), half)).low[0])


def weightings(recorded: LearningCurves, half: slice = slice(None)) -> tuple[FloatArray, Resamples]:
    """Return equal weights of the periods, and resamples of them; 0 outside of `half`."""
    periods = len(recorded.steps)
    return equal(periods, half), Resamples(periods, of=half)


def equal(periods: int, half: slice) -> FloatArray:
    """Return equal weights of some periods, 0 of the others: (1, periods)."""
    weights = np.zeros((1, periods))
    weights[:, half] = 1.0
    equal: FloatArray = weights / weights.sum()
    return equal


def at_the_edge(parameter: str, values: Mapping[Any, object], best: Any, what: str = "best value") -> tuple[str, ...]:
    """Return a remark if a value is the first or last of a grid of numbers: better ones may lie outside of it."""
    if len(values) < 2 or not all(type(each) in (int, float) for each in values):
        return ()
    if best not in (min(values), max(values)):
        return ()
    return (f"the {what}, {parameter} = {best:g}, lies at the edge of its grid",)
