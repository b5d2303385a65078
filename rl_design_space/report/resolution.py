"""Blocks of cells: uniform, split as learning goes on, and single cells, at equal rows and at equal steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.statistics import mean_estimate
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point
from rl_design_space.report.ratios import named, of_periods, ratio
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DASHES, MARKERS, beyond, interval, number, styled, tidy, write_in_full
from rl_design_space.tracking.selection import Where

#: Frames beside the main one: ratios at equal rows, and learning curves by steps.
EQUAL_ROWS, CURVES = "_equal_rows", "_curves"
#: The budget of rows of a point whose blocks are split.
_BUDGET = "curriculum.rows"
#: What is compared at equal rows: steps a trial in the end over the optimum, and steps of all trials.
_MEASURES = ("final_steps_over_optimum", "total_steps")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Resolution(Report):
    """Kinds of blocks by the number of their rows.

    Points are compared at equal rows, as ratios over the same periods, to those of the first kind with as many rows as
    a point may have (`curriculum.rows`); and at equal steps, by the trials that end within them.

    Attributes:
        kinds: values of parameters by the name of a kind; the first one is what others are compared to.
        within: numbers of steps.
    """

    kinds: Annotated[dict[str, dict[str, Any]], Field(min_length=1)]
    within: Annotated[tuple[Annotated[int, Field(ge=1)], ...], Field(strict=False)] = (5_000,)

    choosable: ClassVar[Sequence[str]] = ("colour_map",)

    def frames(self, runs: Runs) -> Frames:
        """Return a row for each point, see the class; `EQUAL_ROWS` and `CURVES` have the ratios and the curves."""
        found = [each for kind, where in self.kinds.items() for each in _results(runs, kind, where)]
        if not found:
            raise ConfigError("study.report.kinds: none of these points has a run")
        rows = [self._row(kind, point, result) for kind, point, result in found]
        curves = pd.concat(
            _curve(result).assign(kind=row["kind"], rows=row["rows"])
            for row, (_, _, result) in zip(rows, found, strict=True)
        )
        return {MAIN: pd.DataFrame(rows), EQUAL_ROWS: self._at_equal_rows(found), CURVES: curves}

    def _row(self, kind: str, point: Point, result: LearningCurves) -> dict[str, Any]:
        row: dict[str, Any] = {"kind": kind, "budget": point.parameters.get(_BUDGET), "rows": result.rows[:, 0].mean()}
        for name in _MEASURES:
            row |= named(name, mean_estimate(of_periods(result, name)))
        ends = np.cumsum(result.steps, axis=1)
        for steps in self.within:
            row |= named(f"trials_in_{steps}", mean_estimate((ends <= steps).sum(axis=1).astype(np.float64)))
        return row | {"periods": len(result.steps)}

    def _at_equal_rows(self, found: list[tuple[str, Point, LearningCurves]]) -> pd.DataFrame:
        """Return the ratios of measures to the first kind, one row for each point whose budget this kind meets."""
        first = next(iter(self.kinds))
        of_first = {int(result.rows[:, 0].mean()): result for kind, _, result in found if kind == first}
        rows = []
        for kind, point, result in found:
            other = of_first.get(point.parameters.get(_BUDGET) or 0)
            if kind == first or other is None:
                continue
            row: dict[str, Any] = {"kind": kind, "budget": point.parameters[_BUDGET], "rows": result.rows[:, 0].mean()}
            for name in _MEASURES:
                row |= named(name, ratio(of_periods(result, name), of_periods(other, name)))
            rows.append(row)
        return pd.DataFrame(rows)

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames, self)

    def text(self, frames: Frames) -> list[str]:
        main, first = frames[MAIN], next(iter(self.kinds))
        names = {"final_steps_over_optimum": "last trials over optimum", "total_steps": "total steps"}
        names |= {f"trials_in_{steps}": f"trials within {steps:,} steps" for steps in self.within}
        texts, equal = _texts(main, names), frames[EQUAL_ROWS]
        for name in _MEASURES if len(equal) else ():
            ratios = dict(zip(zip(equal["kind"], equal["budget"], strict=True), _estimates(equal, name), strict=True))
            keys = zip(main["kind"], main["budget"], strict=True)
            texts[f"{names[name]}, ratio to {first} at equal rows"] = [ratios.get(key, "") for key in keys]
        return [
            table(texts),
            "Rows: the mean number at the end, over periods. Last trials: the mean steps of the last ten trials over "
            "the fewest possible. In parentheses: 95 % bootstrap intervals over periods; ratios are of means over the "
            "same periods. Trials within a number of steps: how many have ended by then, at equal numbers of steps.",
        ]


def _results(runs: Runs, kind: str, where: Where) -> Iterator[tuple[str, Point, LearningCurves]]:
    """Yield the points of a kind that have a run."""
    for point in runs.where(where):
        if result := runs.result(point):
            yield kind, point, result


def _curve(result: LearningCurves) -> pd.DataFrame:
    """Return the mean steps of each trial, and those of all trials before it."""
    steps = result.steps.mean(axis=0)
    return pd.DataFrame({"trial": np.arange(len(steps)), "before": np.cumsum(steps) - steps, "steps": steps})


def _texts(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    texts: dict[str, Any] = {"kind": frame["kind"], "rows": frame["rows"].map("{:.0f}".format)}
    return pd.DataFrame(texts | {heading: _estimates(frame, name) for name, heading in names.items()})


def _estimates(frame: pd.DataFrame, name: str) -> list[str]:
    ends = zip(frame[name], frame[f"{name}_low"], frame[f"{name}_high"], strict=True)
    return [f"{number(value)} ({interval(low, high)})" for value, low, high in ends]


@styled()
def _draw(frames: Frames, look: Resolution) -> Figure:
    main, curves = frames[MAIN], frames[CURVES]
    figure, (final, total, by_steps) = plt.subplots(1, 3, figsize=(13, 4.4), layout="constrained")
    kinds = list(dict.fromkeys(main["kind"]))
    for colour, mark, dashes, kind in zip(look.colours(len(kinds)), MARKERS, DASHES, kinds, strict=False):
        points = main[main["kind"] == kind].sort_values("rows")
        for axis, name in ((final, _MEASURES[0]), (total, _MEASURES[1])):
            reach = beyond(points[f"{name}_low"], points[name], points[f"{name}_high"])
            axis.errorbar(
                points["rows"], points[name], yerr=reach, marker=mark, color=colour, linestyle=dashes, label=kind,
                markersize=5, linewidth=1.3,
            )  # fmt: skip
        for rows in points["rows"]:
            curve = curves[(curves["kind"] == kind) & (curves["rows"] == rows)]
            by_steps.plot(curve["before"][1:], curve["steps"][1:], color=colour, linestyle=dashes, linewidth=1.1)
            last = curve.iloc[-1]
            by_steps.annotate(f"{rows:.0f}", (last["before"], last["steps"]), fontsize=7, color=colour)
    _label(final, "rows of the Q-matrix", "steps of the last ten trials over the optimum")
    _label(total, "rows of the Q-matrix", "steps of all trials")
    _label(by_steps, "steps made before (a line ends with its number of rows)", "steps of a trial")
    final.legend(frameon=False, fontsize=8)
    figure.suptitle(look.title, fontsize=11)
    return figure


def _label(axis: Axes, x: str, y: str) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    for scale, each in ((axis.set_xscale, axis.xaxis), (axis.set_yscale, axis.yaxis)):
        scale("log")
        each.set_major_locator(LogLocator(subs=(1, 2, 5)))
        each.set_tick_params(labelsize=8)
        write_in_full(each)
        each.set_minor_formatter(NullFormatter())
    tidy(axis)
