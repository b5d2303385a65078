"""Pictures of a multiverse: the map of claims and specifications, and the specification curve of a claim."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from rl_design_space.analysis.multiverse.marks import CLEAR
from rl_design_space.report.cells import colour_bar, colour_cells, write
from rl_design_space.report.multiverse_points import AND, DECIDED
from rl_design_space.report.style import BLUE, GREY, VERMILION, styled, tidy

#: Factors from the limit at which a specification curve is cut.
MOST = 4.0
#: Places of a specification curve that a small picture shows.
_PLACES = 61
#: Columns of the map that are choices of a judgement.
_JUDGEMENTS = ("threshold", "statistic", "measure")
_PANELS = {"threshold": "limits", "statistic": "statistics", "measure": "measures"}


def shares(specifications: pd.DataFrame, claims: list[str], column: str, values: list[str]) -> pd.DataFrame:
    """Return the share of specifications with each value under which each claim holds; NaN where there is none."""
    holds = specifications.assign(holds=specifications["holds"].eq(True))
    found = holds.pivot_table(index="claim", columns=column, values="holds", aggfunc="mean")
    return found.reindex(index=claims, columns=values)


def curve(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the specification curve of each claim at evenly spaced places, for a small picture.

    Args:
        rows: all specifications.

    Returns:
        claim, place (share of the specifications before it), log (logarithm of the factor within the limit, 1 at `MOST`
        times) and state (`holds`, `fails` or `unknown`).
    """
    parts = []
    for claim, own in rows.dropna(subset="margin").groupby("claim", sort=False):
        ordered = own.sort_values("margin", kind="stable")
        places = np.linspace(0, len(ordered) - 1, min(_PLACES, len(ordered))).round().astype(int)
        at = ordered.iloc[places]
        state = at["holds"].map({True: "holds", False: "fails"}).fillna("unknown")
        log = (at["margin"] / math.log(MOST)).clip(-1, 1).round(3)
        parts.append(pd.DataFrame({"claim": claim, "place": places / len(ordered), "log": log, "state": state}))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=["claim", "place", "log", "state"])


@styled(font_size=8)
def heatmap(specifications: pd.DataFrame, claims: pd.DataFrame, title: str) -> Figure:
    """Draw the share under which each claim holds: for each reading and judgement, and below for each pair of readings.

    Args:
        specifications: all of them.
        claims: all claims, with their marks.
        title: of the picture.
    """
    marks = claims.set_index("claim")["mark"]
    names = [name for name in claims["claim"] if name in set(specifications["claim"])]
    readings = list(dict.fromkeys(specifications["reading"]))
    single = [reading for reading in readings if AND not in reading]
    numbers = {reading: str(number) for number, reading in enumerate(single)}
    panels = [("readings", "reading", single, [f"{name} [{numbers[name]}]" for name in single])]
    for column in _JUDGEMENTS:
        values = [value for value in dict.fromkeys(specifications[column]) if value]
        panels.append((_PANELS[column], column, values, values))
    panels = [panel for panel in panels if panel[2]]
    pairs = [reading for reading in readings if AND in reading]
    paired = ["+".join(numbers.get(part, "?") for part in pair.split(AND)) for pair in pairs]
    rows, height = 1 + bool(pairs), 0.26 * max(len(names), 3) + 1.6
    figure = plt.figure(figsize=(13, rows * height + 1.6), layout="constrained")
    grid = figure.add_gridspec(rows, len(panels), width_ratios=[len(panel[2]) + 0.5 for panel in panels])
    axes = [figure.add_subplot(grid[0, place]) for place in range(len(panels))]
    if pairs:
        panels.append(("pairs of readings, by their numbers", "reading", pairs, paired))
        axes.append(figure.add_subplot(grid[1, :]))
    norm = Normalize(0, 1)
    for axis, (what, column, values, labels) in zip(axes, panels, strict=True):
        _colour(axis, shares(specifications, names, column, values), norm, few=values is not pairs)
        axis.set_title(what, fontsize=9)
        slanted: dict[str, Any] = {"rotation": 60, "ha": "right", "rotation_mode": "anchor"}
        axis.set_xticks(np.arange(len(values)) + 0.5, labels, **(slanted if values is not pairs else {"rotation": 90}))
        axis.set_yticks(np.arange(len(names)) + 0.5, [""] * len(names))
        if axis is axes[0] or values is pairs:
            axis.set_yticklabels([f"{name}: {marks[name]}" for name in names])
    bar = colour_bar(figure, axes, norm, location="bottom", shrink=0.4, pad=0.02, aspect=40)
    bar.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0%}"))
    bar.set_label("share of specifications under which the claim holds; grey: makes no difference, or is not used")
    figure.suptitle(title, fontsize=11)
    return figure


def _colour(axis: Axes, found: pd.DataFrame, norm: Normalize, few: bool) -> None:
    """Colour the cells of a panel, with numbers in them if they are few."""
    inks = colour_cells(axis, found, norm)
    axis.set_facecolor("0.94")
    axis.set_xlabel("")
    axis.set_ylabel("")
    for (row, place), share in np.ndenumerate(found.to_numpy(float)):
        if few and not math.isnan(share):
            write(axis, place, row, [(0.5, f"{100 * share:.0f}", {"fontsize": 7})], inks[row][place])


@styled(font_size=8)
def specification_curve(rows: pd.DataFrame, title: str) -> Figure:
    """Draw all specifications of a claim in order, and below them which choices each of them makes.

    Args:
        rows: of the claim, with `margin` and `certainty`.
        title: of the picture.
    """
    ordered = rows.sort_values("margin", kind="stable", ignore_index=True)
    choices = [
        ("reading", sorted({part for name in ordered["reading"] for part in name.split(AND)}, key=_decided_first)),
        *((column, [value for value in dict.fromkeys(rows[column]) if value]) for column in _JUDGEMENTS),
    ]
    choices = [(column, values) for column, values in choices if len(values) > 1]
    number = sum(len(values) for _, values in choices)
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(7.5, 2.6 + 0.16 * number), layout="constrained", sharex=True,
        gridspec_kw={"height_ratios": [1.7, 0.16 * max(number, 1)]},
    )  # fmt: skip
    factor = np.exp(ordered["margin"].clip(-math.log(MOST), math.log(MOST)))
    clear = ordered["certainty"].fillna(0) >= CLEAR
    for colour, which in _kinds(ordered):
        for sure, alpha in ((True, 1.0), (False, 0.35)):
            shown = which & (clear == sure)
            places = np.flatnonzero(shown)
            above.scatter(places, factor[shown], s=5, color=colour, alpha=alpha, linewidth=0, rasterized=True)
    above.axhline(1, color="0.3", linewidth=0.8)
    above.set_yscale("log")
    ticks = [1 / MOST, 0.5, 1, 2, MOST]
    above.set_yticks(ticks, [f"{'≤ ' if tick == ticks[0] else '≥ ' if tick == MOST else ''}{tick:g}" for tick in ticks])
    above.minorticks_off()
    above.set_ylim(0.9 / MOST, 1.1 * MOST)
    above.set_ylabel("factor within the limit")
    looks: dict[str, Any] = {"marker": "o", "linestyle": "", "markersize": 4}
    kinds = (("holds", BLUE), ("does not hold", VERMILION), ("cannot be told", GREY))
    handles = [Line2D([], [], color=colour, label=label, **looks) for label, colour in kinds]
    above.legend(handles=handles, frameon=False, fontsize=7, ncols=3, loc="lower right")
    _draw_choices(below, ordered, choices)
    tidy(above)
    share = ordered["holds"].eq(True).mean()
    figure.suptitle(textwrap.shorten(f"{title}", 105, placeholder=" …"), fontsize=9)
    below.set_xlabel(f"{len(ordered):,} specifications in order; the claim holds under {share:.0%} of them")
    return figure


def _kinds(rows: pd.DataFrame) -> list[tuple[Any, Any]]:
    holds, fails = rows["holds"].eq(True), rows["holds"].eq(False)
    return [(BLUE, holds), (VERMILION, fails), (GREY, ~holds & ~fails)]


def _draw_choices(axis: Axes, rows: pd.DataFrame, choices: Sequence[tuple[str, Sequence[str]]]) -> None:
    """Draw a row of ticks for each choice: at the specifications that make it."""
    labels: list[str] = []
    for column, values in choices:
        for value in values:
            made = np.array([value in (name.split(AND) if column == "reading" else [name]) for name in rows[column]])
            for colour, which in _kinds(rows):
                places = np.flatnonzero(made & which)
                row = np.full(len(places), len(labels))
                axis.scatter(places, row, marker="|", s=18, linewidth=0.4, color=colour, rasterized=True)
            labels.append(value)
        axis.axhline(len(labels) - 0.5, color="0.8", linewidth=0.6)
    axis.set_yticks(range(len(labels)), labels, fontsize=7)
    axis.set_ylim(len(labels) - 0.5, -0.5)
    axis.tick_params(length=0)
    axis.spines[["top", "right"]].set_visible(False)


def _decided_first(name: str) -> tuple[bool, str]:
    return name != DECIDED, name
