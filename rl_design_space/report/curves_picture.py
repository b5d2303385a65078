"""The picture of a figure of learning curves."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from rl_design_space.report.style import DASHES, MARKERS, beyond, colours, draw_curve, make_logarithmic, styled, tidy

#: Panels side by side.
_COLUMNS = 2
#: Height of what a panel shows, from top to bottom, in inches; the last only if there are families.
_HEIGHTS = {"steps of a trial": 3.6, "failed": 0.8, "total steps of a period": 2.6}
_NOTE = (
    "Lines: mean over periods of the steps of a trial, with its 95 % interval; logarithmic. Below: share of periods in "
    "which the trial misses the final goal.\nDashed grey: fewest steps possible. Dotted grey: a random walk (expected, "
    "without the step cap)."
)
_EXPLORATION_NOTE = (
    "\nBottom: total steps of a period against the total exploration of its schedule (the sum of ε over the trials), "
    "a point a value of the schedule's parameters."
)


@styled()
def draw_curves_figure(
    curves: pd.DataFrame,
    lines: pd.DataFrame,
    panels: pd.DataFrame,
    exploration: pd.DataFrame,
    title: str,
    families: Sequence[str],
) -> Figure:
    """Draw panels side by side: curves, failed trials, and, if there are families, total steps against exploration.

    Args:
        curves: as `CurvesFigure.frames` returns them, like the three other frames.
        lines: one row for each line.
        panels: one row for each panel.
        exploration: one row for each point of the families.
        title: of the picture.
        families: names of the families.
    """
    heights = list(_HEIGHTS.values())[: 3 if families else 2]
    blocks, across = -(-len(panels) // _COLUMNS), min(len(panels), _COLUMNS)
    most_failed = max(0.01, float(curves["failed"].max()) if len(curves) else 0.0)
    figure, axes = plt.subplots(
        blocks * len(heights), across, layout="constrained", squeeze=False, sharey="row",
        figsize=(5.6 * across, blocks * sum(heights) + 1.5), height_ratios=heights * blocks,
    )  # fmt: skip
    for number, panel in enumerate(panels.to_dict("records")):
        block, column = divmod(number, _COLUMNS)
        above, below, *lowest = axes[block * len(heights) : (block + 1) * len(heights), column]
        of_lines, of_curves, of_points = (
            each[each["panel"] == panel["panel"]] for each in (lines, curves, exploration)
        )
        _draw_curves(above, below, of_lines, of_curves)
        if not np.isnan(panel["optimum"]):
            for level, dashes in (("optimum", "--"), ("random_walk", ":")):
                above.axhline(panel[level], color="0.45", linestyle=dashes, linewidth=1)
        make_logarithmic(above)
        below.set_ylim(0, 1.05 * most_failed)
        above.set_title(panel["panel"], fontsize=11)
        for axis in lowest:
            _draw_exploration(axis, of_points, families)
        if column == 0:
            for axis, name in zip((above, below, *lowest), _HEIGHTS, strict=False):
                axis.set_ylabel(name)
    figure.suptitle(title, fontsize=12)
    figure.supxlabel(_NOTE + (_EXPLORATION_NOTE if families else ""), fontsize=8)
    return figure


def _draw_curves(above: Axes, below: Axes, lines: pd.DataFrame, curves: pd.DataFrame) -> None:
    handles = []
    for line, colour, dashes in zip(lines.to_dict("records"), colours(len(lines)), DASHES * len(lines), strict=False):
        missing = np.isnan(line["total_steps"])
        label = f"{line['line']} (missing)" if missing else line["line"]
        handles.append(Line2D([], [], color=colour, linestyle=dashes, label=label))
        if not missing:
            curve = curves[curves["line"] == line["line"]]
            draw_curve(above, curve, colour, dashes)
            below.plot(curve["trial"], curve["failed"], color=colour, linestyle=dashes, linewidth=1.1)
    above.legend(handles=handles, frameon=False, fontsize=8, loc="best", ncols=1 + (len(handles) > 4))
    above.set_xticklabels([])
    below.set_xlabel("trial")
    below.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    for axis in (above, below):
        axis.set_xlim(left=0)
        tidy(axis)


def _draw_exploration(axis: Axes, points: pd.DataFrame, families: Sequence[str]) -> None:
    for (family, colour), marker in zip(zip(families, colours(len(families)), strict=True), MARKERS, strict=False):
        here = points[points["family"] == family].sort_values("exploration")
        axis.errorbar(
            here["exploration"], here["total_steps"],
            yerr=beyond(here["total_low"], here["total_steps"], here["total_high"]), color=colour, marker=marker,
            markersize=4, linewidth=1, linestyle="-" if here["joined"].all() else "none", label=family,
        )  # fmt: skip
    make_logarithmic(axis)
    axis.set_xlabel("total exploration of the schedule")
    axis.legend(frameon=False, fontsize=8)
    tidy(axis)
