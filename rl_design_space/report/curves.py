"""Learning curves by the values of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._ahead import ahead
from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.averaging import curve_of_runs, pooled
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import CURVES_OF_PERIODS
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.heatmap import Names
from rl_design_space.report.parameters import check_averaged, label
from rl_design_space.report.points import Point, by_design, repetition
from rl_design_space.report.runs import Runs
from rl_design_space.report.stage_marks import GREY, STAGES, begins_of

#: Lines that can be told apart.
_MOST = 12
_COLUMNS = ["line", "trial", "mean", "ci_low", "ci_high", "runs"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Curves(Report):
    """A line for each value of some parameters, the mean over the runs that have it.

    Attributes:
        by: parameters whose values make the lines.
        curve: which learning curve, see `LearningCurves.curves`.
        mean: whether runs of one line that differ in more than their seed are averaged.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    by: Names
    curve: str = "steps/mean"
    mean: bool = False
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("order", "scale", "colour_map")

    @property
    def heading(self) -> str:
        return self.title or f"{self.curve} by {', '.join(self.by)}"

    def frames(self, runs: Runs) -> Frames:
        """Return the curves, and where their stages begin.

        Returns:
            MAIN: line, trial, mean, ci_low, ci_high (95 % over periods), runs: one row for each line and trial.
            STAGES: line, begin: one row for each trial with which a stage but the first begins in a run of the line.
        """
        lines = {key: [point for point in points if point.run] for key, points in runs.grouped(self.by).items()}
        lines = {key: points for key, points in lines.items() if points}
        if len(lines) > _MOST:
            raise ConfigError(f"{', '.join(self.by)}: {len(lines)} lines cannot be told apart; choose with --where")
        parts, begins = [], []
        for key, points in lines.items():
            name = label(self.by, key)
            parameters = [point.choices for point in points]
            check_averaged(parameters, f"line ({name})", "give them lines with --by", self.mean)
            for _ in ahead(runs.kept, points, runs.in_flight):
                pass  # it is remembered
            lengths = {len(runs.curve(point, self.curve)) for point in points}
            if len(lengths) > 1:
                found = " or ".join(map(str, sorted(lengths)))
                raise ConfigError(f"task.trials: runs of one line ({name}) have {found}")
            mean, low, high = self._line(runs, points)
            part = pd.DataFrame({"mean": mean, "ci_low": low, "ci_high": high}).rename_axis("trial").reset_index()
            parts.append(part.assign(line=name, runs=len(points))[_COLUMNS])
            begun = sorted({begin for point in points for begin in begins_of(runs, point)})
            begins += [{"line": name, "begin": begin} for begin in begun]
        curves = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=_COLUMNS)
        return {MAIN: curves, STAGES: pd.DataFrame(begins, columns=["line", "begin"])}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN]}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], frames[STAGES], self)

    def text(self, frames: Frames) -> list[str]:
        """Return the level at which each line ends."""
        staged = len(frames[STAGES]) > 0
        last = frames[MAIN].groupby("line", sort=False).last()
        ends = [f"- {name}: {style.number(row['mean'])}, {int(row['runs'])} runs" for name, row in last.iterrows()]
        return [
            "At the last trial:",
            "\n".join(ends),
            "Bands: 95 % bootstrap intervals over periods, where these are kept.",
            *(["Vertical lines: a stage begins, in the colour of its line unless all lines agree."] * staged),
        ]

    def tables(self, frames: Frames) -> list[pd.DataFrame]:
        """Return the level at which each line ends."""
        last = frames[MAIN].groupby("line", sort=False).last().reset_index()
        return [
            pd.DataFrame(
                {
                    "line": last["line"],
                    f"{self.curve} at the last trial": last["mean"].map(style.number),
                    "95 % interval": list(map(style.interval, last["ci_low"], last["ci_high"])),
                    "runs": last["runs"],
                }
            )
        ]

    def _line(self, runs: Runs, points: list[Point]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the mean curve of points, and its interval; NaN where the periods are not known."""
        mean: FloatArray = np.mean([self._of_design(runs, seeds) for seeds in by_design(points)], axis=0)
        results = [runs.kept(point) for point in points]
        values = CURVES_OF_PERIODS.get(self.curve)
        if values is None or None in results:
            nothing = np.full(len(mean), np.nan)
            return mean, nothing, nothing
        periods = [np.asarray(values(result), float) for result in results if result]
        return mean, *curve_of_runs(periods, [repetition(point) for point in points])

    def _of_design(self, runs: Runs, seeds: list[Point]) -> FloatArray:
        """Return the curve of all periods of a design; the mean of the curves of its seeds if they are not known."""
        results = [result for point in seeds if (result := runs.kept(point))]
        if len(seeds) > 1 and len(results) == len(seeds):
            return pooled(results).curves[self.curve]
        mean: FloatArray = np.mean([runs.curve(point, self.curve) for point in seeds], axis=0)
        return mean


@style.styled()
def _draw(frame: pd.DataFrame, stages: pd.DataFrame, look: Curves) -> Figure:
    names = list(frame["line"].unique())
    figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
    for place, (name, colour) in enumerate(zip(names, look.colours(len(names), "husl"), strict=True)):
        style.draw_curve(axis, frame[frame["line"] == name], colour, style.DASHES[place % len(style.DASHES)], name)
    of_line = dict(zip(names, look.colours(len(names), "husl"), strict=True))
    shared = stages["begin"].value_counts() == len(names)
    for stage in stages.drop_duplicates("begin").to_dict("records"):
        colour = GREY if shared[stage["begin"]] else of_line[stage["line"]]
        axis.axvline(stage["begin"] - 0.5, color=colour, linewidth=0.8, alpha=0.6, gid=STAGES)
    are_steps = look.curve.startswith("steps/") and len(frame) > 0 and frame["mean"].min() > 0
    if look.is_log(frame["mean"], by_itself=are_steps):
        style.make_logarithmic(axis)
    axis.set_xlabel("trial")
    axis.set_ylabel(look.curve)
    axis.set_title(look.heading, fontsize=11)
    style.tidy(axis)
    if names:
        style.legend_beside(axis)
    return figure
