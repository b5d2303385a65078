"""Pairs of points that are equal in everything but what is compared: differences and ratios, period by period."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.averaging import estimate_difference, mean_of_runs, value_of_sides
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.learning.measures import Measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.bounds import BOUNDS

#: Names of a ratio and the ends of its interval.
OF_RATIO = "ratio", "ratio_low", "ratio_high"


class Pair(NamedTuple):
    """Two sides that are equal in everything else, for one seed.

    Attributes:
        before: results of one side, equally many periods of each.
        after: results of the other side.
        repetition: designs of both sides, and their seed.
    """

    before: list[LearningCurves]
    after: list[LearningCurves]
    repetition: Repetition


def row_of(measured: Measure, pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return the mean over pairs of a measure on both sides, and of its difference with the interval."""
    found = _by_period(measured, pairs)
    return {**(found or _resampled(measured, pairs)), "periods": sum(len(pair.before[0].steps) for pair in pairs)}


def _by_period(measured: Measure, pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return a row of means over pairs of their means over periods; nothing if the measure is no mean over periods."""
    before, after = (
        [values for side in sides if (values := _values(measured, side)) is not None]
        for sides in ([pair.before for pair in pairs], [pair.after for pair in pairs])
    )
    if len(before) < len(pairs):
        return {}
    differences = [other - one for one, other in zip(before, after, strict=True)]
    _, low, high = mean_of_runs(differences, [pair.repetition for pair in pairs])
    means = {"a": before, "b": after, "difference": differences}
    row: dict[str, Any] = {name: _mean_over_designs(pairs, values) for name, values in means.items()}
    return {**row, "low": low, "high": high, BOUNDS: ""}


def _values(measured: Measure, results: Sequence[LearningCurves]) -> FloatArray | None:
    """Return the number of each period, the mean over results; None if the measure is no mean over periods."""
    known = [values for result in results if (values := measured.each(result)) is not None]
    if not known:
        return None
    mean: FloatArray = known[0] if len(known) == 1 else np.mean(known, axis=0)
    return mean


def _resampled(measured: Measure, pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return a row of a measure of whole curves, or of a statistic other than the mean."""
    repetitions = [pair.repetition for pair in pairs]
    before, after = [pair.before for pair in pairs], [pair.after for pair in pairs]
    a, b = (value_of_sides(measured, side, repetitions) for side in (before, after))
    difference = estimate_difference(measured, before, after, repetitions)
    named = {"a": a.bounds, "b": b.bounds, "difference": difference.bounds}
    bounds = ", ".join(each.replace("value", name) for name, each in named.items() if each)
    row = {"a": a.value, "b": b.value, "difference": difference.value}
    return {**row, "low": difference.low, "high": difference.high, BOUNDS: bounds}


def ratio_of(measured: Measure, pairs: Sequence[Pair]) -> dict[str, float]:
    """Return the ratio of the means of both sides, of several designs the geometric mean, with its 95 % interval.

    NaN if a mean is not positive, or the measure is no mean over periods.
    The interval is that of the mean of b_i / b − a_i / a over periods i, the linear part of log(b / a).
    """
    nothing = dict.fromkeys(OF_RATIO, np.nan)
    before, after = (
        [values for side in sides if (values := _values(measured, side)) is not None]
        for sides in ([pair.before for pair in pairs], [pair.after for pair in pairs])
    )
    if len(before) < len(pairs):
        return nothing
    designs: dict[Hashable, list[int]] = {}
    for place, pair in enumerate(pairs):
        designs.setdefault(pair.repetition.design, []).append(place)
    logs: list[FloatArray] = [np.empty(0)] * len(pairs)
    for places in designs.values():
        a, b = (float(np.concatenate([side[place] for place in places]).mean()) for side in (before, after))
        if a <= 0 or b <= 0:
            return nothing
        for place in places:
            logs[place] = np.log(b / a) + after[place] / b - before[place] / a
    found = mean_of_runs(logs, [pair.repetition for pair in pairs])
    return dict(zip(OF_RATIO, map(float, np.exp(found)), strict=True))


def _mean_over_designs(pairs: Sequence[Pair], values: Sequence[FloatArray]) -> float:
    designs: dict[Hashable, list[FloatArray]] = {}
    for pair, each in zip(pairs, values, strict=True):
        designs.setdefault(pair.repetition.design, []).append(each)
    return float(sum(np.concatenate(seeds).mean() for seeds in designs.values()) / len(designs))
