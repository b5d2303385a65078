"""Drawing a figure of learning curves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt
import seaborn as sns
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, PercentFormatter

from rl_design_space.analysis.learning_curves import random_walk_steps
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.report.heatmap import SETTINGS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rl_design_space.report.curves import CurvesFigure, Line

#: Told apart without colours, too.
DASHES: list[Any] = ["-", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2))]
MARKERS = "osD^vP"
#: Panels side by side.
_COLUMNS = 2
_NOTE = (
    "Lines: mean over periods of the steps of a trial, with its 95 % interval; logarithmic. Below: share of periods in "
    "which the trial misses the final goal.\nDashed grey: fewest moves possible. Dotted grey: a random walk (expected, "
    "without the step cap)."
)
_EXPLORATION_NOTE = (
    "\nBottom: total steps of a period against the total exploration of its schedule (the sum of ε over the trials), "
    "a point a value of the schedule's parameters."
)


def draw(figure: CurvesFigure, lines: list[Line], curves: pd.DataFrame, exploration: pd.DataFrame) -> Figure:
    """Panels side by side: curves, failed trials, and, if there are families, total steps against exploration.

    Args:
        figure: what to draw.
        lines: of all panels.
        curves: as `CurvesFigure.frame` returns them.
        exploration: as `CurvesFigure.exploration_frame` returns it.
    """
    panels = list(dict.fromkeys(line.panel for line in lines))
    heights = [3.6, 0.8, *([2.6] if figure.families else [])]
    blocks = -(-len(panels) // _COLUMNS)
    most_failed = max(0.01, float(curves["failed"].max()) if len(curves) else 0.0)
    with mpl.rc_context(SETTINGS):
        drawn, axes = plt.subplots(
            blocks * len(heights), min(len(panels), _COLUMNS), layout="constrained", squeeze=False, sharey="row",
            figsize=(5.6 * min(len(panels), _COLUMNS), blocks * sum(heights) + 1.5), height_ratios=heights * blocks,
        )  # fmt: skip
        for number, panel in enumerate(panels):
            block, column = divmod(number, _COLUMNS)
            above, below, *lowest = axes[block * len(heights) : (block + 1) * len(heights), column]
            here = [line for line in lines if line.panel == panel]
            _draw_curves(above, below, here, curves[curves["panel"] == panel])
            below.set_ylim(0, 1.05 * most_failed)
            above.set_title(panel, fontsize=11)
            for axis in lowest:
                _draw_exploration(axis, figure, exploration[exploration["panel"] == panel])
            if column == 0:
                above.set_ylabel("steps of a trial")
                below.set_ylabel("failed")
                for axis in lowest:
                    axis.set_ylabel("total steps of a period")
        drawn.suptitle(figure.title, fontsize=12)
        drawn.supxlabel(_NOTE + (_EXPLORATION_NOTE if figure.families else ""), fontsize=8)
    return drawn


def _draw_curves(axis: Axes, below: Axes, lines: list[Line], curves: pd.DataFrame) -> None:
    colours = sns.color_palette("colorblind", len(lines))
    handles = []
    for line, colour, dashes in zip(lines, colours, DASHES * len(lines), strict=False):
        label = line.name if line.recorded else f"{line.name} (missing)"
        handles.append(Line2D([], [], color=colour, linestyle=dashes, label=label))
        if not line.recorded:
            continue
        curve = curves[curves["line"] == line.name]
        draw_curve(axis, curve, colour, dashes)
        below.plot(curve["trial"], curve["failed"], color=colour, linestyle=dashes, linewidth=1.1)
    recorded = next((line for line in lines if line.recorded), None)
    if recorded and recorded.recorded:
        point = recorded.planned.point
        axis.axhline(float(recorded.recorded.optimum.mean()), color="0.45", linestyle="--", linewidth=1)
        axis.axhline(random_walk_steps(point.world, layouts_of(point)), color="0.45", linestyle=":", linewidth=1)
    make_logarithmic(axis)
    axis.legend(handles=handles, frameon=False, fontsize=8, loc="best", ncols=1 + (len(handles) > 4))
    axis.set_xticklabels([])
    below.set_xlabel("trial")
    below.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    for each in (axis, below):
        each.set_xlim(left=0)
        tidy(each)


def draw_curve(axis: Axes, curve: pd.DataFrame, colour: Any, dashes: Any) -> None:
    """A learning curve in its band; `curve` has trial, mean, ci_low and ci_high."""
    axis.fill_between(curve["trial"], curve["ci_low"], curve["ci_high"], color=colour, alpha=0.25, linewidth=0)
    axis.plot(curve["trial"], curve["mean"], color=colour, linestyle=dashes, linewidth=1.4)


def _draw_exploration(axis: Axes, figure: CurvesFigure, points: pd.DataFrame) -> None:
    colours = sns.color_palette("colorblind", len(figure.families))
    for (family, colour), marker in zip(zip(figure.families, colours, strict=True), MARKERS, strict=False):
        here = points[points["family"] == family].sort_values("exploration")
        beyond = np.array([here["total_steps"] - here["total_low"], here["total_high"] - here["total_steps"]])
        axis.errorbar(
            here["exploration"], here["total_steps"], yerr=np.nan_to_num(beyond), color=colour, marker=marker,
            markersize=4, linewidth=1, linestyle="-" if family != "sigmoidal" else "none", label=family,
        )  # fmt: skip
    make_logarithmic(axis)
    axis.set_xlabel("total exploration of the schedule")
    axis.legend(frameon=False, fontsize=8)
    tidy(axis)


def tidy(axis: Axes) -> None:
    """A grid to read values by, and no frame."""
    axis.set_axisbelow(True)
    axis.grid(color="0.92")
    axis.spines[["top", "right"]].set_visible(False)


def make_logarithmic(axis: Axes) -> None:
    """A logarithmic axis with plain numbers at 1, 2, 5 of every decade."""
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
    axis.yaxis.set_minor_formatter(NullFormatter())
