"""How much a scalar depends on one parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
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
from rl_design_space.report.fitting import make_room
from rl_design_space.report.look import LINEAR, LOG, RATIO
from rl_design_space.report.many import HALF, MOST, Named, Top, apart, named, without_effect
from rl_design_space.report.markdown import table
from rl_design_space.report.not_shown import NOT_SHOWN, not_shown
from rl_design_space.report.parameters import label, text
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.report.written import MainNumbers

#: Lines that all have a colour and a name of their own; of more, the range is drawn, their median, and few by name.
_NAMED, _FEW = 8, 3
_EVERYTHING = "all runs"
#: Name of the frame of sentences on runs that are not shown; it is no file.
_NOT_SHOWN = "_not_shown"
#: Least distance of labels on a logarithmic axis, as a share of the axis.
_GAP = 0.07


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sensitivity(Report):
    """A scalar against the values of a parameter, a line for each combination of the other choices.

    Of more than eight lines, the picture shows the range, the median and a few lines by name. They are relative, each
    to the geometric mean of its values where all lines have one, unless a scale is chosen: otherwise the range would
    be that of the levels of lines, not of what the parameter does. A line has a gap at a value without a run; runs that
    are equal to no other in everything else are not shown, which the report says.

    Attributes:
        parameter: along the axis.
        value: scalar or measure that is shown, see docs/reports.md.
        named: lines that are drawn by name if there are many, and that the text lists in any case, by values that they
            have; the three that depend most on the parameter if left out.
        top: number of lines that the text lists, those that depend most after those that are named; all are in the CSV
            file.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    parameter: str
    value: ValueName = "total_steps"
    named: Named = ()
    top: Top = 20
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("order", "scale", "colour_map")
    scales: ClassVar[Sequence[str]] = (LINEAR, LOG, RATIO)

    @property
    def heading(self) -> str:
        return self.title or f"{self.value} against {self.parameter}"

    def frames(self, runs: Runs) -> Frames:
        """Return line, parameter, value, low, high (95 % over periods), bounds, runs: a row a value of a line."""
        points = [point for point in runs.recorded if point.parameters.get(self.parameter) is not None]
        runs.check([self.parameter])
        others = differing([point.choices for point in points], beside=(self.parameter,))
        lines: dict[tuple[Any, ...], dict[tuple[Any, ...], list[Point]]] = {}
        shown: list[Point] = []
        alone: list[Point] = []
        for key, line in runs.grouped(others, points).items():
            values = runs.grouped([self.parameter], line)
            (shown if len(values) > 1 else alone).extend(line)
            if len(values) > 1:
                lines[key] = values
        # A line is named by what tells it apart from the other lines, not from runs that are not shown.
        telling = differing([point.choices for point in shown], beside=(self.parameter,))
        rows: list[dict[str, Any]] = []
        for key, values in lines.items():
            name = label(telling, [value for other, value in zip(others, key, strict=True) if other in telling])
            name = name or label(others, key) or _EVERYTHING
            for (value,), here in values.items():
                estimate = runs.estimate(here, self.value)
                rows.append({"line": name, self.parameter: value, **estimate._asdict(), "runs": len(here)})
        notes = list(not_shown(self.parameter, others, alone, shown))
        if not rows:
            why = "".join(f"; {note.removeprefix(f'{NOT_SHOWN} ').rstrip('.')}" for note in notes[:1])
            raise ConfigError(
                f"{self.parameter}: no two of these runs differ in it and are equal in everything else{why}"
            )
        return {MAIN: without_exact(pd.DataFrame(rows)), _NOT_SHOWN: pd.DataFrame({"note": notes})}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN]}

    def main_numbers(self, frames: Frames) -> MainNumbers:
        """Return the table of the lines, below what it does not show."""
        unused = without_effect(self.named, frames[MAIN]["line"].nunique(), min(_NAMED, self.top), "line")
        return replace(super().main_numbers(frames), lines=(*unused, *map(self.words, _notes(frames))))

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self, _notes(frames))

    def text(self, frames: Frames) -> list[str]:
        """Return least and largest value of each line, and their ratio."""
        rows = []
        lines = {str(name): line for name, line in frames[MAIN].groupby("line", sort=False)}
        wanted = named(lines, self.named)
        many = len(lines) > self.top
        others = [name for name in _most_dependent(frames[MAIN]) if name not in wanted] if many else []
        listed = [*wanted, *others[: max(0, self.top - len(wanted))]] if many else list(lines)
        for name in listed:
            ordered = lines[name].sort_values("value").to_dict("records")
            least, most = ordered[0], ordered[-1]
            ends = [(text(end[self.parameter]), f"{shown(end)} ({shown_interval(end)})") for end in (least, most)]
            is_known = least["value"] > 0 and not is_bound(least) and not is_bound(most)
            ratio = style.number(most["value"] / least["value"]) if is_known else "–"
            rows.append((name, *ends[0], *ends[1], ratio))
        header = ["line", f"least {self.value} at", "least", "most at", "most", "most / least"]
        return [
            *([_left_out(len(listed), len(lines), len(wanted))] if many else []),
            table(pd.DataFrame(rows, columns=header)),
            *_notes(frames),
            "In brackets: 95 % bootstrap intervals over periods.",
            *([f"{NOTE} {NO_RATIO.capitalize()}."] if BOUNDS in frames[MAIN] else []),
        ]

    def is_relative(self, frame: pd.DataFrame) -> bool:
        """Return whether lines are shown relative to their means.

        Raises:
            ConfigError: that was asked for, and a value is not positive.
        """
        positive = bool((frame["value"] > 0).all())
        if self.scale == RATIO and not positive:
            raise ConfigError.at("scale", RATIO, f"needs numbers above 0; the least is {frame['value'].min():g}")
        return self.scale == RATIO or (not self.scale and positive and frame["line"].nunique() > _NAMED)


def _notes(frames: Frames) -> list[str]:
    """Return sentences on runs that are not shown."""
    return list(frames[_NOT_SHOWN]["note"]) if _NOT_SHOWN in frames else []


def _left_out(listed: int, lines: int, wanted: int) -> str:
    """Return which of the lines the text lists."""
    which = f"The {listed} of {lines} lines that depend most"
    if wanted:
        others = " and those that depend most" if listed > wanted else ""
        which = f"{listed} of {lines} lines, {wanted} by name{others}"
    return f"{which}; the CSV file has the others."


def _relative(frame: pd.DataFrame) -> pd.DataFrame:
    """Return values and their intervals over the geometric mean of their line, where all lines have values."""
    lines = frame["line"].nunique()
    everywhere = frame.groupby("x")["line"].transform("nunique") == lines
    logs = np.log(frame["value"])
    means = np.exp(logs.where(everywhere | (not everywhere.any())).groupby(frame["line"]).transform("mean"))
    return frame.assign(**{name: frame[name] / means for name in ("value", "low", "high")})


def _most_dependent(frame: pd.DataFrame) -> list[str]:
    """Return lines by the ratio of their largest to their least value; by the difference if one is not positive."""
    ends = frame.groupby("line", sort=False)["value"].agg(["min", "max"])
    spread = ends["max"] / ends["min"] if (ends["min"] > 0).all() else ends["max"] - ends["min"]
    return [str(name) for name in spread.sort_values(ascending=False, kind="stable").index]


@style.styled()
def _draw(frame: pd.DataFrame, look: Sensitivity, notes: Sequence[str] = ()) -> Figure:
    names = list(frame["line"].unique())
    few = len(names) <= _NAMED
    values = frame[look.parameter].unique().tolist()
    # An order that was asked for is that of the axis.
    numeric = look.parameter not in look.order and all(
        isinstance(each, int | float) and not isinstance(each, bool) for each in values
    )
    frame = frame.assign(x=frame[look.parameter] if numeric else [values.index(each) for each in frame[look.parameter]])
    relative = look.is_relative(frame)
    drawn = _relative(frame) if relative else frame
    figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
    wanted = named(names, look.named)
    shown = names if few else wanted or _most_dependent(frame)[:_FEW]
    others = [] if few else _draw_range(axis, drawn)
    lines = []
    places = list(frame["x"].unique())
    legends, common = apart(shown)
    for place, (name, legend, colour) in enumerate(zip(shown, legends, look.colours(len(shown)), strict=True)):
        line = _with_gaps(drawn[drawn["line"] == name], places)
        lines.append(
            axis.errorbar(
                line["x"], line["value"], yerr=style.beyond(line["low"], line["value"], line["high"]),
                color=colour, marker=style.MARKERS[place % len(style.MARKERS)], markersize=4,
                linewidth=1.2, label=legend,
            )
        )  # fmt: skip
    if relative:
        style.show_ratios(axis.yaxis, float(drawn["value"].min()), float(drawn["value"].max()))
    elif look.is_log(frame["value"]):
        style.make_logarithmic(axis)
    _scale(axis, [look.words.value(look.parameter, value) for value in values], values, numeric)
    axis.set_xlabel(look.parameter)
    axis.set_ylabel(f"{look.value}{', relative to the mean of its line' if relative else ''}")
    if relative:
        axis.axhline(1, color="0.4", linewidth=0.8, zorder=1)
    axis.set_title(look.heading, fontsize=11)
    style.tidy(axis)
    if names != [_EVERYTHING]:
        style.legend_beside(axis, [*others, *lines])
    if below := "\n".join([*([common] if common else []), *notes]):
        figure.supxlabel(below, fontsize=7.5)
    if not few or below:
        make_room(figure)
    return figure


def _with_gaps(line: pd.DataFrame, places: Sequence[float]) -> pd.DataFrame:
    """Return a line with a gap at each place of the axis where it has no value."""
    missing = sorted(set(places) - set(line["x"]))
    return line.merge(pd.DataFrame({"x": missing}), how="outer", on="x").sort_values("x") if missing else line


def _draw_range(axis: Axes, frame: pd.DataFrame) -> list[Any]:
    """Draw where most lines lie, and their median; return what stands in the legend."""
    values = frame.groupby("x")["value"]
    bands = [
        axis.fill_between(
            values.min().index, values.quantile(low), values.quantile(high), color=colour, linewidth=0, label=name
        )
        for (low, high), colour, name in (
            (MOST, "0.9", f"80 % of {frame['line'].nunique()} lines"),
            (HALF, "0.78", "half of them"),
        )
    ]
    return [*bands, *axis.plot(values.median(), color="black", linewidth=2, label="their median")]


def _scale(axis: Axes, names: list[str], values: list[Any], numeric: bool) -> None:
    """Make the x-axis logarithmic if its numbers span a decade; write other values below it, as they read."""
    if not numeric:
        axis.set_xticks(range(len(values)), names)
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
