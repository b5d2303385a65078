"""A figure of learning curves: panels of lines, the share of failed trials, and total steps against exploration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._markdown import code
from rl_design_space._strict import STRICT
from rl_design_space.analysis.learning_curves import curve_frame, curve_summary
from rl_design_space.config.build import construct
from rl_design_space.learning.measures import FINAL_TRIALS, NEAR
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.baselines import MORE, NO_LEVELS, above_optimum, line_baselines, told_of_memoryless
from rl_design_space.report.beside import beside
from rl_design_space.report.fitting import break_headings
from rl_design_space.report.look import Look
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design, different_choices
from rl_design_space.report.runs import Runs
from rl_design_space.report.scratch import SCRATCH, SCRATCH_NOTE, draw_scratch, scratch_frame, told_of_scratch
from rl_design_space.report.stage_marks import GREY, LEVELS, STAGE_NOTE, STAGES, draw_stages, stage_frame
from rl_design_space.report.style import (
    DASHES,
    MARKERS,
    beyond,
    draw_curve,
    interval,
    make_logarithmic,
    share_limits,
    styled,
    tidy,
)
from rl_design_space.tracking.selection import Where

#: Frames beside the main one; only the first is written.
EXPLORATION, LINES, PANELS = "_exploration", "lines", "panels"
_CURVE_COLUMNS = ["panel", "line", "trial", "mean", "ci_low", "ci_high", "median", "q10", "q90", "failed"]
_EXPLORATION_COLUMNS = [
    "panel", "family", "point", "exploration", "total_steps", "total_low", "total_high",
    "final_over_optimum", "final_low", "final_high", "failed",
]  # fmt: skip
#: Panels side by side.
_COLUMNS = 2
#: Height of what a panel shows, from top to bottom, in inches; the last only if there are families.
_HEIGHTS = {"steps of a trial": 3.6, "failed": 0.8, "total steps of a period": 2.6}
_NOTE = (
    "Lines: mean over periods of the steps of a trial, with its 95 % interval; logarithmic. Below: share of periods in "
    "which the trial misses the final goal.\nDashed grey: fewest steps possible. Dotted grey: a random walk (expected, "
    "without the step cap)."
)
_MEMORYLESS_NOTE = " Dash-dotted: the best memoryless policy, where it needs more steps."
_EXPLORATION_NOTE = (
    "\nBottom: total steps of a period against the total exploration of its schedule (the sum of ε over the trials), "
    "one point for each value of its parameters."
)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Panel:
    """A panel of a figure.

    Attributes:
        title: above it.
        where: what its points have in common.
        lines: points by the name of their line: the values that each has in addition.
    """

    title: Text
    where: Where
    lines: Annotated[dict[str, Where], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CurvesFigure(Report):
    """Learning curves with 95 % bands, beside the optimum and a random walk.

    Attributes:
        panels: in their order, each with `title`, `where` (what its points have in common) and `lines` (points by the
            name of their line: the values that each has in addition).
        families: kinds of schedules by name, each the values that its points have in common; if there are any, a row of
            panels shows total steps against total exploration.
    """

    title: Text
    shows: Text
    panels: Annotated[list[dict[str, Any]], Field(min_length=1)]
    families: dict[str, Where] = Field(default_factory=dict)

    choosable: ClassVar[Sequence[str]] = ("scale", "colour_map")

    def built_panels(self) -> list[Panel]:
        """Return the panels, validated.

        Raises:
            ConfigError: a panel has a value that is not allowed.
        """
        return [construct(Panel, node, f"study.report.panels.{i}") for i, node in enumerate(self.panels)]

    def points(self, runs: Runs) -> dict[tuple[str, str], list[Point]]:
        """Return the points of each line, one for each seed, by the names of its panel and its own.

        Raises:
            ConfigError: the values of a line do not belong to exactly one design.
        """
        return {
            (panel.title, line): runs.seeds({**panel.where, **where})
            for panel in self.built_panels()
            for line, where in panel.lines.items()
        }

    def frames(self, runs: Runs) -> Frames:
        """Return what is drawn and written.

        Returns:
            MAIN: panel, line, and the columns of `analysis.learning_curves.curve_frame`: one row for each trial of a
                recorded line.
            EXPLORATION: panel, family, point, joined (whether the family varies one parameter alone), and columns of
                `curve_summary`: one row for each recorded point of the families.
            LINES: panel, line, command, memoryless (steps of a trial of the best memoryless policy, NaN if not known),
                and the columns of `curve_summary`, NaN if missing: one row for each line.
            PANELS: panel; optimum and random_walk, steps of a trial, NaN if nothing is recorded.
            STAGES: panel, and columns of `stage_frame`: one row for each stage of the line that has the most.
            SCRATCH: see `scratch_frame`.
        """
        points = self.points(runs)
        results = {names: runs.pooled(seeds) for names, seeds in points.items()}
        baselines = beside(lambda: line_baselines(points, results))
        curves = [
            curve_frame(result).assign(panel=panel, line=line)[_CURVE_COLUMNS]
            for (panel, line), result in results.items()
            if result
        ]
        summaries = {tuple(points[names]): curve_summary(result) for names, result in results.items() if result}
        exploration = self._exploration(runs, summaries)
        memoryless, of_panels = baselines()
        lines = [
            {
                "panel": panel,
                "line": line,
                "command": _missing(points[panel, line]).planned.command,
                "memoryless": memoryless.get((panel, line), float("nan")),
                "total_steps": float("nan"),
                **(summaries[tuple(points[panel, line])] if result else {}),
            }
            for (panel, line), result in results.items()
        ]
        panels = [{"panel": panel.title, **of_panels.get(panel.title, NO_LEVELS)} for panel in self.built_panels()]
        return {
            MAIN: pd.concat(curves) if curves else pd.DataFrame(columns=_CURVE_COLUMNS),
            EXPLORATION: exploration,
            LINES: pd.DataFrame(lines),
            PANELS: pd.DataFrame(panels),
            STAGES: stage_frame(points, results),
            SCRATCH: scratch_frame(runs, points, results),
        }

    def csv(self, frames: Frames) -> Frames:
        curves = {MAIN: frames[MAIN], **({SCRATCH: frames[SCRATCH]} if len(frames[SCRATCH]) else {})}
        return curves | {EXPLORATION: frames[EXPLORATION][_EXPLORATION_COLUMNS]} if self.families else curves

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames, self)

    def text(self, frames: Frames) -> list[str]:
        """Return the lines in numbers."""
        header = ["panel", "line", "total steps", "95 % interval", "trials to final level", "final steps / optimum"]
        rows = [[line["panel"], line["line"], *_numbers(line)] for line in frames[LINES].to_dict("records")]
        return [
            table(pd.DataFrame(rows, columns=[*header, "failed"])),
            "Total steps: steps of all trials of a period, mean over periods with its 95 % BCa interval. Trials to "
            f"final level: until the mean curve of steps / optimum stays within {NEAR} times its mean over the last "
            f"{FINAL_TRIALS} trials. Failed trials count with the steps up to the step cap.",
            *told_of_memoryless(frames[LINES], frames[PANELS]),
            *told_of_scratch(frames[SCRATCH], has_stages=len(frames[STAGES]) > 0),
        ]

    def _exploration(self, runs: Runs, known: Mapping[tuple[Point, ...], Mapping[str, float]]) -> pd.DataFrame:
        """Return the points of the families; `known` has the summaries of those that are lines as well."""
        rows = []
        for panel in self.built_panels():
            for family, where in self.families.items():
                points = runs.where({**panel.where, **where})
                joined = len(different_choices(points)) <= 1
                for seeds in by_design(points):
                    if result := runs.pooled(seeds):
                        names = {"panel": panel.title, "family": family, "point": seeds[0].planned.name}
                        summary = known.get(tuple(seeds)) or curve_summary(result)
                        rows.append({**names, "joined": joined, **summary})
        return pd.DataFrame(rows, columns=[*_EXPLORATION_COLUMNS, "joined"])


def _missing(seeds: Sequence[Point]) -> Point:
    """Return a point without a run, if there is one."""
    return next((point for point in seeds if point.run is None), seeds[0])


def _numbers(line: Mapping[Any, Any]) -> list[str]:
    if pd.isna(line["total_steps"]):
        return [f"missing: {code(line['command'])}", "", "", "", ""]
    return [
        f"{line['total_steps']:,.0f}",
        interval(line["total_low"], line["total_high"], ",.0f"),
        f"{line['trials_to_final']:.0f}",
        f"{line['final_over_optimum']:.3f} ({interval(line['final_low'], line['final_high'], '.3f')})",
        f"{line['failed']:.2%} ({interval(line['failed_low'], line['failed_high'], '.2%')})",
    ]


@styled()
def _draw(frames: Frames, look: CurvesFigure) -> Figure:
    """Draw panels side by side: curves, failed trials, and, if there are families, total steps against exploration."""
    curves, panels, families = frames[MAIN], frames[PANELS], list(look.families)
    is_log = look.is_log(curves["mean"], by_itself=True)
    heights = list(_HEIGHTS.values())[: 3 if families else 2]
    columns = 1 if look.is_narrow else _COLUMNS
    blocks, across = -(-len(panels) // columns), min(len(panels), columns)
    most_failed = max(0.01, float(curves["failed"].max()) if len(curves) else 0.0)
    figure, axes = plt.subplots(
        blocks * len(heights), across, layout="constrained", squeeze=False, sharey="row",
        figsize=(5.6 * across, blocks * sum(heights) + 1.5), height_ratios=heights * blocks,
    )  # fmt: skip
    for number, panel in enumerate(panels.to_dict("records")):
        block, column = divmod(number, columns)
        above, below, *lowest = axes[block * len(heights) : (block + 1) * len(heights), column]
        of = {name: frame[frame["panel"] == panel["panel"]] for name, frame in frames.items()}
        _draw_curves(above, below, of[LINES], of[MAIN], look, draw_scratch(above, of[SCRATCH]))
        draw_stages(above, below, of[STAGES])
        if not np.isnan(panel["optimum"]):
            for level, dashes in LEVELS if of[STAGES].empty else ():
                above.axhline(panel[level], color=GREY, linestyle=dashes, linewidth=1)
            for line, colour in zip(of[LINES].to_dict("records"), look.colours(len(of[LINES])), strict=True):
                if line["memoryless"] > MORE * panel["optimum"]:
                    above.axhline(line["memoryless"], color=colour, linestyle="-.", linewidth=1)
        if is_log:
            make_logarithmic(above)
        below.set_ylim(0, 1.05 * most_failed)
        above.set_title(panel["panel"], fontsize=11)
        for axis in lowest:
            _draw_exploration(axis, of[EXPLORATION], look, is_log)
        if column == 0:
            for axis, name in zip((above, below, *lowest), _HEIGHTS, strict=False):
                axis.set_ylabel(name)
    for kind in range(len(heights)) if across == 1 else ():
        share_limits(axes[kind :: len(heights), 0].tolist())
    figure.suptitle(look.title, fontsize=12)
    notes = _NOTE if is_log else _NOTE.replace("; logarithmic", "")
    notes += (STAGE_NOTE if len(frames[STAGES]) else "") + (SCRATCH_NOTE if len(frames[SCRATCH]) else "")
    notes += _MEMORYLESS_NOTE if len(above_optimum(frames[LINES], panels)) else ""
    figure.supxlabel(notes + (_EXPLORATION_NOTE if families else ""), fontsize=8)
    break_headings(figure)
    return figure


def _draw_curves(
    above: Axes, below: Axes, lines: pd.DataFrame, curves: pd.DataFrame, look: Look, more: Sequence[Line2D]
) -> None:
    handles, chosen = [], look.colours(len(lines))
    for line, colour, dashes in zip(lines.to_dict("records"), chosen, DASHES * len(lines), strict=False):
        missing = np.isnan(line["total_steps"])
        label = f"{line['line']} (missing)" if missing else line["line"]
        handles.append(Line2D([], [], color=colour, linestyle=dashes, label=label))
        if not missing:
            curve = curves[curves["line"] == line["line"]]
            draw_curve(above, curve, colour, dashes)
            below.plot(curve["trial"], curve["failed"], color=colour, linestyle=dashes, linewidth=1.1)
    handles += more
    above.legend(handles=handles, frameon=False, fontsize=8, loc="best", ncols=1 + (len(handles) > 4))
    above.set_xticklabels([])
    below.set_xlabel("trial")
    below.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    for axis in (above, below):
        axis.set_xlim(left=0)
        tidy(axis)


def _draw_exploration(axis: Axes, points: pd.DataFrame, look: CurvesFigure, is_log: bool) -> None:
    chosen = look.colours(len(look.families))
    for (family, colour), marker in zip(zip(look.families, chosen, strict=True), MARKERS, strict=False):
        here = points[points["family"] == family].sort_values("exploration")
        axis.errorbar(
            here["exploration"], here["total_steps"],
            yerr=beyond(here["total_low"], here["total_steps"], here["total_high"]), color=colour, marker=marker,
            markersize=4, linewidth=1, linestyle="-" if here["joined"].all() else "none", label=family,
        )  # fmt: skip
    if is_log:
        make_logarithmic(axis)
    axis.set_xlabel("total exploration of the schedule")
    axis.legend(frameon=False, fontsize=8)
    tidy(axis)
