"""Two choices side by side, everything else equal: how much more one needs than the other, period by period."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.averaging import estimate_difference, mean_of_runs, value_of_sides
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import Measure, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.differences import differing
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.bounds import BOUNDS, notes, shown, shown_interval, without_exact
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import SEED, check_averaged, label, order
from rl_design_space.report.points import Point, repetition
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DARK_BLUE, beyond, styled, tidy
from rl_design_space.tracking.run_frame import typed

#: Name of the row of all pairs together.
_ALL = "all pairs"
#: Height of a row and longest side of the picture, in inches.
_HEIGHT, _LONGEST = 0.36, 40

_PAIRED = (
    "Paired by period of each seed: both sides met the same starts and goals, unless seed, world or number of goals is "
    "what is compared."
)
#: Parameters by name in which both sides of a pair are equal.
_Rest = tuple[tuple[str, Any], ...]


class _Pair(NamedTuple):
    """Two sides that are equal in everything else, for one seed.

    Attributes:
        before: results of one side, equally many periods of each.
        after: results of the other side.
        repetition: designs of both sides, and their seed.
    """

    before: list[LearningCurves]
    after: list[LearningCurves]
    repetition: Repetition


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Compare(Report):
    """Differences of pairs of points that are equal in everything but what is compared.

    Points of equal seed and size meet the same starts and goals, so each period of one is compared with the same
    period of the other: which layouts were drawn does not matter.

    Attributes:
        a: values of parameters, as on the command line: `representation=ad_hoc`; several with spaces between.
        b: values of the same parameters on the other side.
        value: measure that is compared, see docs/reports.md.
        mean: whether runs of one side that differ in what is compared are averaged, period by period.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    a: str
    b: str
    value: MeasureName = "total_steps"
    mean: bool = False
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value}: {self.b} minus {self.a}"

    def frames(self, runs: Runs) -> Frames:
        """Return pair, a, b, difference (b − a), low, high (95 %, paired), periods: one row a pair, all pairs last."""
        sides = [_wanted(side) for side in (self.a, self.b)]
        if sides[0] == sides[1]:
            raise ConfigError(f"{self.a}, {self.b}: both sides are the same; name two that differ")
        compared = {name for side in sides for name in side}
        runs.check(compared)
        ours, theirs = (self._by_rest(runs, side, compared) for side in sides)
        common = [rest for rest in ours if rest in theirs]
        if not common:
            found = [sum(map(len, side.values())) for side in (ours, theirs)]
            raise ConfigError(
                f"{self.a}, {self.b}: no two runs are equal in everything else ({found[0]} and {found[1]} runs)"
            )
        others = differing([dict(rest) for rest in common], beside=compared)
        pairs: dict[tuple[Any, ...], list[_Pair]] = {}
        for rest in sorted(common, key=lambda rest: [order(dict(rest).get(name)) for name in others]):
            key = tuple(dict(rest).get(name) for name in others if name != SEED)
            pairs.setdefault(key, []).append(self._pair(runs, ours[rest], theirs[rest], dict(rest)))
        names, measured = [name for name in others if name != SEED], measure(self.value)
        for key, seeds in pairs.items():
            if len({pair.repetition.design for pair in seeds}) > 1:
                where = f" of {label(names, key)}" if names else ""
                raise ConfigError(f"{SEED}: not all runs{where} that are averaged have the same seeds; use --where")
        rows = [{"pair": label(names, key) or "the pair", **_row(measured, seeds)} for key, seeds in pairs.items()]
        if len(pairs) > 1:
            rows.append({"pair": _ALL, **_row(measured, [pair for seeds in pairs.values() for pair in seeds])})
        return {MAIN: without_exact(pd.DataFrame(rows))}

    def _by_rest(self, runs: Runs, side: Mapping[str, Any], compared: set[str]) -> dict[_Rest, list[Point]]:
        """Return the runs of a side by everything in which those of a pair are equal.

        Raises:
            ConfigError: several runs of the side are equal in that, and their mean is not asked for.
        """
        found: dict[_Rest, list[Point]] = {}
        for point in runs.recorded:
            if point.has(side):
                found.setdefault(_rest(point, compared), []).append(point)
        name = label(side, side.values())
        for points in found.values():
            advice = f"name its value beside {name}"
            check_averaged([point.choices for point in points], f"side ({name})", advice, self.mean)
        return found

    def _pair(self, runs: Runs, ours: Sequence[Point], theirs: Sequence[Point], rest: Mapping[str, Any]) -> _Pair:
        before, after = (self._results(runs, points) for points in (ours, theirs))
        common = min(len(each.steps) for each in (*before, *after))
        before, after = ([each.first(common) for each in side] for side in (before, after))
        designs = tuple(repetition(point).design for point in (*ours, *theirs))
        return _Pair(before, after, Repetition(designs, rest.get(SEED)))

    def _results(self, runs: Runs, points: Sequence[Point]) -> list[LearningCurves]:
        """Return the results of the points of one side."""
        results = [result for point in points if (result := runs.kept(point))]
        if len(results) < len(points):
            raise ConfigError(f"{self.value}: is not known period by period for {_described(points[0])}")
        return results

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.value, self.heading)

    def text(self, frames: Frames) -> list[str]:
        """Return one row for each pair."""
        pairs, rows = frames[MAIN], frames[MAIN].to_dict("records")
        texts = pd.DataFrame(
            {
                "pair": pairs["pair"],
                self.a: [shown(pair, "a") for pair in rows],
                self.b: [shown(pair, "b") for pair in rows],
                "difference": [shown(pair, "difference") for pair in rows],
                "95 % interval": list(map(shown_interval, rows)),
                "periods": pairs["periods"],
            }
        )
        return [table(texts), _PAIRED, *notes(pairs)]


@styled()
def _draw(frame: pd.DataFrame, value: str, title: str) -> Figure:
    height = min(_HEIGHT * len(frame) + 1.6, _LONGEST)
    figure, axis = plt.subplots(figsize=(7.5, height), layout="constrained")
    y = np.arange(len(frame))[::-1]
    reach = beyond(frame["low"], frame["difference"], frame["high"])
    clear = (frame["low"] > 0) | (frame["high"] < 0)
    for which, face in ((clear, DARK_BLUE), (~clear, "white")):
        axis.errorbar(
            frame["difference"][which], y[which], xerr=reach[:, which], fmt="o",
            color=DARK_BLUE, markerfacecolor=face, markersize=5, linewidth=1.2,
        )  # fmt: skip
    axis.axvline(0, color="0.4", linewidth=1)
    axis.set_yticks(y, frame["pair"])
    axis.set_ylim(-0.6, len(frame) - 0.4)
    axis.xaxis.set_major_formatter(lambda number_, _: f"{number_:,g}")
    axis.set_xlabel(f"difference of {value} with its 95 % interval; hollow: the interval contains 0")
    axis.set_title(title, fontsize=11)
    tidy(axis)
    return figure


def _wanted(side: str) -> dict[str, Any]:
    """Return `representation=ad_hoc exploration.k=0.02` as values by name.

    Raises:
        ConfigError: a part has no equals sign.
    """
    wanted = {}
    for part in side.split():
        name, equals, value = part.partition("=")
        if not equals:
            raise ConfigError(f"{side}: should be values of parameters, such as representation=ad_hoc")
        wanted[name] = typed(value)
    return wanted


def _rest(point: Point, compared: set[str]) -> _Rest:
    """Return everything in which both points of a pair are equal: all but what is compared and its values."""
    prefixes = tuple(f"{name}." for name in compared)
    known = {**point.choices, SEED: point.parameters.get(SEED)}
    rest = {name: value for name, value in known.items() if name not in compared}
    return tuple(sorted((name, value) for name, value in rest.items() if not name.startswith(prefixes)))


def _described(point: Point) -> str:
    return point.run.run_id if point.run else "a point without a run"


def _row(measured: Measure, pairs: Sequence[_Pair]) -> dict[str, Any]:
    """Return the mean over pairs of a measure on both sides, and of its difference with the interval."""
    found = _by_period(measured, pairs)
    return {**(found or _resampled(measured, pairs)), "periods": sum(len(pair.before[0].steps) for pair in pairs)}


def _by_period(measured: Measure, pairs: Sequence[_Pair]) -> dict[str, Any]:
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


def _resampled(measured: Measure, pairs: Sequence[_Pair]) -> dict[str, Any]:
    """Return a row of a measure of whole curves, or of a statistic other than the mean."""
    repetitions = [pair.repetition for pair in pairs]
    before, after = [pair.before for pair in pairs], [pair.after for pair in pairs]
    a, b = (value_of_sides(measured, side, repetitions) for side in (before, after))
    difference = estimate_difference(measured, before, after, repetitions)
    named = {"a": a.bounds, "b": b.bounds, "difference": difference.bounds}
    bounds = ", ".join(each.replace("value", name) for name, each in named.items() if each)
    row = {"a": a.value, "b": b.value, "difference": difference.value}
    return {**row, "low": difference.low, "high": difference.high, BOUNDS: bounds}


def _mean_over_designs(pairs: Sequence[_Pair], values: Sequence[FloatArray]) -> float:
    designs: dict[Hashable, list[FloatArray]] = {}
    for pair, each in zip(pairs, values, strict=True):
        designs.setdefault(pair.repetition.design, []).append(each)
    return float(sum(np.concatenate(seeds).mean() for seeds in designs.values()) / len(designs))
