"""Blocks of cells: uniform, split as learning goes on, and single cells, at equal rows and at equal steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.statistics import Estimate, mean_estimate, percentile_interval, resample_weights
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DASHES, MARKERS, beyond, colours, interval, number, styled, tidy, write_in_full
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
            row |= _named(name, mean_estimate(_values(result, name)))
        ends = np.cumsum(result.steps, axis=1)
        for steps in self.within:
            row |= _named(f"trials_in_{steps}", mean_estimate((ends <= steps).sum(axis=1).astype(np.float64)))
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
                row |= _named(name, _ratio(_values(result, name), _values(other, name)))
            rows.append(row)
        return pd.DataFrame(rows)

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames, self.title)

    def text(self, frames: Frames) -> list[str]:
        main, first = frames[MAIN], next(iter(self.kinds))
        names = {"final_steps_over_optimum": "last trials over optimum", "total_steps": "total steps"}
        names |= {f"trials_in_{steps}": f"trials within {steps:,} steps" for steps in self.within}
        parts = [table(_texts(main, names))]
        if len(frames[EQUAL_ROWS]):
            equal = {name: f"{names[name]}, ratio to {first}" for name in _MEASURES}
            parts += ["## At equal numbers of rows", table(_texts(frames[EQUAL_ROWS], equal))]
        return [
            *parts,
            "Rows: the mean number at the end, over periods. Last trials: the mean steps of the last ten trials over "
            "the fewest possible. In parentheses: 95 % bootstrap intervals over periods; ratios are of means over the "
            "same periods. Trials within a number of steps: how many have ended by then, at equal numbers of steps.",
        ]

    def numbers(self, frames: Frames) -> list[str]:
        return [
            f"{row['kind']}, {row['rows']:.0f} rows: last trials {row['final_steps_over_optimum']:.3g} times the "
            f"optimum, {row['total_steps']:,.0f} steps in all, "
            + ", ".join(f"{row[f'trials_in_{steps}']:.1f} trials in {steps:,}" for steps in self.within)
            for row in frames[MAIN].to_dict("records")
        ] + [
            f"{row['kind']} at {row['budget']} rows: last trials {row['final_steps_over_optimum']:.3g} "
            f"({interval(row['final_steps_over_optimum_low'], row['final_steps_over_optimum_high'])}) times those of "
            f"{next(iter(self.kinds))}, total steps {row['total_steps']:.3g} "
            f"({interval(row['total_steps_low'], row['total_steps_high'])})"
            for row in frames[EQUAL_ROWS].to_dict("records")
        ]


def _results(runs: Runs, kind: str, where: Where) -> Iterator[tuple[str, Point, LearningCurves]]:
    """Yield the points of a kind that have a run."""
    for point in runs.where(where):
        if result := runs.result(point):
            yield kind, point, result


def _values(result: LearningCurves, name: str) -> FloatArray:
    values = measure(name).each(result)
    assert values is not None
    return values


def _named(name: str, estimate: Estimate) -> Mapping[str, float]:
    return {name: estimate.value, f"{name}_low": estimate.low, f"{name}_high": estimate.high}


def _ratio(values: FloatArray, others: FloatArray) -> Estimate:
    """Return the ratio of the means over the periods that both have, with its interval over periods."""
    common = min(len(values), len(others))
    weights = resample_weights(common)
    low, high = percentile_interval(weights @ values[:common] / (weights @ others[:common]))
    return Estimate(float(values[:common].mean() / others[:common].mean()), float(low), float(high))


def _curve(result: LearningCurves) -> pd.DataFrame:
    """Return the mean steps of each trial, and those of all trials before it."""
    steps = result.steps.mean(axis=0)
    return pd.DataFrame({"trial": np.arange(len(steps)), "before": np.cumsum(steps) - steps, "steps": steps})


def _texts(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    texts: dict[str, Any] = {"kind": frame["kind"], "rows": frame["rows"].map("{:.0f}".format)}
    for name, heading in names.items():
        ends = zip(frame[name], frame[f"{name}_low"], frame[f"{name}_high"], strict=True)
        texts[heading] = [f"{number(value)} ({interval(low, high)})" for value, low, high in ends]
    return pd.DataFrame(texts)


@styled()
def _draw(frames: Frames, title: str) -> Figure:
    main, curves = frames[MAIN], frames[CURVES]
    figure, (final, total, by_steps) = plt.subplots(1, 3, figsize=(13, 4.4), layout="constrained")
    kinds = list(dict.fromkeys(main["kind"]))
    for colour, mark, dashes, kind in zip(colours(len(kinds)), MARKERS, DASHES, kinds, strict=False):
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
    figure.suptitle(title, fontsize=11)
    return figure


def _label(axis: Axes, x: str, y: str) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    for scale, each in ((axis.set_xscale, axis.xaxis), (axis.set_yscale, axis.yaxis)):
        scale("log")
        each.set_major_locator(LogLocator(subs=(1, 2, 5)))
        write_in_full(each)
        each.set_minor_formatter(NullFormatter())
    tidy(axis)
