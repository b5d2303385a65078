"""The picture of heavy tails: the periods, how failed trials end, and where the agent was caught."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, PercentFormatter

from rl_design_space.analysis.endings import CIRCLE, CIRCLE_IN_ONE, ENDINGS, LAST, WANDERING, WANDERING_IN_ONE, ending
from rl_design_space.learning.replay import Replay
from rl_design_space.learning.sequential.method import Path
from rl_design_space.report.inside.grid import Grid
from rl_design_space.report.style import BLUE, VERMILION, make_logarithmic, styled, tidy

_COLOURS = {CIRCLE_IN_ONE: VERMILION, CIRCLE: "#e69f00", WANDERING_IN_ONE: BLUE, WANDERING: "#9ecae1"}
_CAUGHT = "#d4c9e8"
#: Inches: height of the row of a design, and that where there are more than so many; widths of its panels.
_HEIGHT, _LOWER, _FEW, _WIDTHS = 2.5, 1.7, 4, (3.4, 3.8, 2.4)
_POINTS_PER_INCH = 72
#: Ranks that are free on both sides of those of the periods.
_BESIDE = 0.5
#: Characters of the name of a design in a line, for an inch of its row.
_LETTERS = 13.6


@styled()
def draw_failures(designs: pd.DataFrame, periods: pd.DataFrame, examples: pd.DataFrame, title: str) -> Figure:
    """Draw a row for each design.

    Args:
        designs: the main frame of `Failures`.
        periods: its frame of periods.
        examples: its frame of examples.
        title: above the picture.
    """
    height = _HEIGHT if len(designs) <= _FEW else _LOWER
    figure, axes = plt.subplots(
        len(designs), len(_WIDTHS), squeeze=False, layout="constrained",
        figsize=(sum(_WIDTHS), height * len(designs) + 1.3), width_ratios=_WIDTHS,
    )  # fmt: skip
    for row, design in enumerate(designs.to_dict("records")):
        left, middle, right = axes[row]
        _draw_periods(left, periods[periods["design"] == design["design"]])
        left.set_ylabel(_broken(str(design["design"]), int(_LETTERS * height)), fontsize=8)
        _draw_endings(middle, design)
        example = examples[examples["design"] == design["design"]]
        if len(example):
            _draw_example(right, example["inside"].iloc[0], int(example["trial"].iloc[0]))
        else:
            right.set_axis_off()
            right.text(0.5, 0.5, "no failed trial\namong the periods examined", ha="center", va="center", color="0.4")
    axes[-1, 0].set_xlabel("rank among the periods examined; filled: a trial failed", fontsize=7)
    axes[0, 0].set_title("steps over optimum of the tail,\nthe worst period first", fontsize=9)
    axes[0, 1].set_title("how failed trials end", fontsize=9)
    axes[0, 2].set_title("the end of one of them", fontsize=9)
    handles: list[Any] = [Patch(color=colour, label=kind) for kind, colour in _COLOURS.items()]
    handles += [
        Line2D([], [], color="0.3", linestyle="--", label="best memoryless policy"),
        Line2D([], [], color=VERMILION, linewidth=2, label=f"path, last {LAST:,} steps"),
        Patch(color=_CAUGHT, label="cells with the observation met most often"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.suptitle(title, fontsize=12)
    return figure


def _draw_periods(axis: Axes, periods: pd.DataFrame) -> None:
    """Draw total steps over those of the optimum, by rank; filled where a trial failed."""
    trials = periods["trials"].iloc[0]
    over = periods["total_steps"] / (trials * periods["optimum"])
    ranks = np.arange(1, len(over) + 1)
    failed = (periods["failed_trials"] > 0).to_numpy()
    axis.plot(ranks, over, color="0.6", linewidth=1)
    axis.scatter(ranks[failed], over[failed], s=14, color=VERMILION, zorder=3)
    axis.scatter(ranks[~failed], over[~failed], s=14, facecolor="white", edgecolor="0.4", zorder=3)
    best = (periods["memoryless_steps"] / periods["optimum"]).to_numpy()
    ends = ranks[0] - _BESIDE, ranks[-1] + _BESIDE
    # From side to side, so that there is a line for a single period, too.
    axis.plot([ends[0], *ranks, ends[1]], best[[0, *(ranks - 1), -1]], color="0.3", linestyle="--", linewidth=1.2)
    make_logarithmic(axis)
    axis.set_ylim(bottom=0.8)
    axis.set_xlim(*ends)
    axis.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    tidy(axis)


def _draw_endings(axis: Axes, design: dict[Any, Any]) -> None:
    shares = [0.0 if pd.isna(design[kind]) else design[kind] for kind in ENDINGS]
    places = np.arange(len(ENDINGS))
    axis.barh(places, shares, color=list(_COLOURS.values()), height=0.7)
    for place, share in zip(places, shares, strict=True):
        axis.annotate(f"{share:.0%}", (share, place), (4, 0), textcoords="offset points", va="center", fontsize=8)
    axis.set_yticks(places, ENDINGS, fontsize=8)
    axis.invert_yaxis()
    axis.set_xlim(0, 1.12)
    axis.xaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    none = (
        "" if pd.isna(design["without_exploration"]) else f", {design['without_exploration']:.0%} without exploration"
    )
    axis.set_xlabel(f"of {_counted(design['failed_trials'], 'failed trial')}{none}", fontsize=8)
    tidy(axis)


def _draw_example(axis: Axes, inside: Replay, trial: int) -> None:
    """Draw the end of a failed trial, with the cells of the observation that it met most often."""
    assert inside.paths is not None
    end = ending(inside, trial)
    whole = inside.paths[trial]
    last = Path(whole.cells[-LAST - 1 :], whole.counters[-LAST - 1 :], whole.actions[-LAST:], whole.explored[-LAST:])
    grid = Grid(inside.point)
    grid.draw(axis)
    caught = np.ma.masked_equal(inside.row[end.reached] == end.row, False)
    axis.imshow(grid.image(caught), cmap=ListedColormap([_CAUGHT]), interpolation="nearest", zorder=1)
    here = last.counters[:-1] == end.reached
    pairs, counts = np.unique(
        np.stack([last.cells[:-1][here], last.cells[1:][here]], axis=1), axis=0, return_counts=True
    )
    lines, owners = grid.segments(pairs)
    cell = _WIDTHS[2] * _POINTS_PER_INCH / max(grid.width, grid.height)
    often = np.log10(counts[owners])
    widths = np.minimum(1.2 + 0.8 * often, 0.3 * cell)
    strength = 0.35 + 0.65 * often / max(often.max(), 1e-9) if len(often) else 1
    axis.add_collection(LineCollection(lines, colors=VERMILION, linewidths=widths, alpha=strength, zorder=8))
    grid.draw_places(axis, inside.layout, end.reached, 0.8 * cell)
    round_ = f"a circle of {end.circle} steps" if end.circle else _counted(end.observations, "observation")
    where = f"period {inside.period}, trial {trial}, to goal {end.reached + 1}"
    axis.set_xlabel(f"{where}:\n{round_}", fontsize=8)


def _broken(name: str, letters: int) -> str:
    """Return a name with line breaks between its parts, so that its lines have about so many letters."""
    lines = [""]
    for part in name.split():
        if lines[-1] and len(lines[-1]) + len(part) >= letters:
            lines.append("")
        lines[-1] = f"{lines[-1]} {part}".strip()
    return "\n".join(lines)


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}{'' if number == 1 else 's'}"
