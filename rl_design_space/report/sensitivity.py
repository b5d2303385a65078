"""How much a scalar depends on one parameter."""

from __future__ import annotations

import math
from typing import Any

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.censoring import NO_RATIO
from rl_design_space.config.measure_name import ValueName
from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.bounds import BOUNDS, NOTE, is_bound, shown, shown_interval, without_exact
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import label, text
from rl_design_space.report.runs import Runs

#: Lines that have a colour and a name of their own; more lines are drawn thin and grey, with their median.
_NAMED = 8
_EVERYTHING = "all runs"
#: Least distance of labels on a logarithmic axis, as a share of the axis.
_GAP = 0.07


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sensitivity(Report):
    """A scalar against the values of a parameter, a line for each combination of the other choices.

    Attributes:
        parameter: along the axis.
        value: scalar or measure that is shown, see docs/reports.md.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    parameter: str
    value: ValueName = "total_steps"
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value} against {self.parameter}"

    def frames(self, runs: Runs) -> Frames:
        """Return line, parameter, value, low, high (95 % over periods), bounds, runs: a row a value of a line."""
        points = [point for point in runs.recorded if point.parameters.get(self.parameter) is not None]
        runs.check([self.parameter])
        others = differing([point.choices for point in points], beside=(self.parameter,))
        rows = []
        for key, line in runs.grouped(others, points).items():
            values = runs.grouped([self.parameter], line)
            for (value,), here in values.items() if len(values) > 1 else ():
                estimate = runs.estimate(here, self.value)
                name = label(others, key) or _EVERYTHING
                rows.append({"line": name, self.parameter: value, **estimate._asdict(), "runs": len(here)})
        if not rows:
            raise ConfigError(f"{self.parameter}: no two of these runs differ in it and are equal in everything else")
        return {MAIN: without_exact(pd.DataFrame(rows))}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.parameter, self.value, self.heading)

    def text(self, frames: Frames) -> list[str]:
        """Return least and largest value of each line, and their ratio."""
        rows = []
        for name, line in frames[MAIN].groupby("line", sort=False):
            ordered = line.sort_values("value").to_dict("records")
            least, most = ordered[0], ordered[-1]
            ends = [(text(end[self.parameter]), f"{shown(end)} ({shown_interval(end)})") for end in (least, most)]
            is_known = least["value"] > 0 and not is_bound(least) and not is_bound(most)
            ratio = style.number(most["value"] / least["value"]) if is_known else "–"
            rows.append((name, *ends[0], *ends[1], ratio))
        header = ["line", f"least {self.value} at", "least", "most at", "most", "most / least"]
        return [
            table(pd.DataFrame(rows, columns=header)),
            "In brackets: 95 % bootstrap intervals over periods.",
            *([f"{NOTE} {NO_RATIO.capitalize()}."] if BOUNDS in frames[MAIN] else []),
        ]


@style.styled()
def _draw(frame: pd.DataFrame, parameter: str, value: str, title: str) -> Figure:
    names = list(frame["line"].unique())
    few = len(names) <= _NAMED
    values = frame[parameter].unique().tolist()
    numeric = all(isinstance(each, int | float) and not isinstance(each, bool) for each in values)
    frame = frame.assign(x=frame[parameter] if numeric else [values.index(each) for each in frame[parameter]])
    figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
    for place, (name, colour) in enumerate(
        zip(names, style.colours(len(names)) if few else ["0.6"] * len(names), strict=True)
    ):
        line = frame[frame["line"] == name]
        axis.errorbar(
            line["x"], line["value"], yerr=style.beyond(line["low"], line["value"], line["high"]) if few else None,
            color=colour, marker=style.MARKERS[place % len(style.MARKERS)] if few else None, markersize=4,
            linewidth=1.2 if few else 0.6, label=name,
        )  # fmt: skip
    shown = None
    if not few:
        median = frame.groupby("x")["value"].median()
        shown = axis.plot(median.index, median, color="black", linewidth=2, label=f"median of {len(names)} lines")
    _scale(axis, frame["value"], values, numeric)
    axis.set_xlabel(parameter)
    axis.set_ylabel(value)
    axis.set_title(title, fontsize=11)
    style.tidy(axis)
    if names != [_EVERYTHING]:
        style.legend_beside(axis, shown)
    return figure


def _scale(axis: Axes, heights: pd.Series[float], values: list[Any], numeric: bool) -> None:
    """Make axes logarithmic where their numbers span a decade; write other values below the axis."""
    if heights.min() > 0 and heights.max() / heights.min() >= style.DECADE:
        style.make_logarithmic(axis)
    if not numeric:
        axis.set_xticks(range(len(values)), [text(value) for value in values])
        return
    ordered = sorted(values)
    if ordered[0] > 0 and ordered[-1] / ordered[0] >= style.DECADE:
        axis.set_xscale("log")
        ticks = _spaced(ordered)
        axis.set_xticks(ticks, [text(value) for value in ticks], minor=False)
        axis.minorticks_off()
    elif all(isinstance(value, int) for value in values):
        axis.set_xticks(ordered)


def _spaced(values: list[float]) -> list[float]:
    """Return values in ascending order whose labels do not overlap on a logarithmic axis."""
    gap = _GAP * math.log(values[-1] / values[0])
    kept = values[:1]
    for value in values[1:]:
        if math.log(value / kept[-1]) >= gap:
            kept.append(value)
    return kept
