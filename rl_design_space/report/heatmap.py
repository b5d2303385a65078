"""Heatmaps of cells that were published and measured."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt
import seaborn as sns
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator

from rl_design_space.report.markdown import interval_text
from rl_design_space.report.published_table import HEAVY_TAIL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure

    from rl_design_space.report.published_table import PublishedTable

# Even in lightness from end to end, so that it reads in grey and for colour-blind eyes.
_COLOURS = "cividis_r"
#: Of every picture: the same bytes for the same figure, and text that stays text.
SETTINGS: dict[Any, Any] = {"svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "font.size": 9}

_LEGEND = (
    "Large: mean over periods, with its 95 % interval. Failures: share of periods in which a trial missed the goal.\n"
    f"† heavy tail: the 1 % of periods with most steps need {HEAVY_TAIL} times the mean or more."
)

#: Height within the cell, text, and how it looks.
Line = tuple[float, str, dict[str, Any]]


def draw(cells: pd.DataFrame, table: PublishedTable) -> Figure:
    """One heatmap a panel: colour and large number are measured, below them stand interval, paper and ratio.

    Args:
        cells: as `analysis.published.compare_with_published` returns them.
        table: names and labels.
    """
    panel, row, column = table.axes
    panels = list(cells[panel].unique())
    measured = cells["measured"].dropna()
    norm = LogNorm(measured.min(), measured.max()) if len(measured) else LogNorm(1, 10)
    with mpl.rc_context(SETTINGS):
        figure, axes = plt.subplots(
            1, len(panels), figsize=(5.4 * len(panels) + 0.6, 5.0), layout="constrained", squeeze=False
        )
        for axis, name in zip(axes[0], panels, strict=True):
            here = cells[cells[panel] == name]
            values = here.pivot_table(index=row, columns=column, values="measured", dropna=False, sort=False)
            inks = colour_cells(axis, values, norm, square=True)
            _annotate(axis, here, values, row, column, inks)
            axis.set_title(table.label(name), fontsize=11)
            axis.set_xlabel(table.label(column))
            axis.set_ylabel(table.label(row))
        bar = colour_bar(
            figure, axes[0].tolist(), norm, shrink=0.8, ticks=LogLocator(subs=(1, 2, 5)), format="{x:,.0f}"
        )
        bar.set_label("measured, logarithmic")
        figure.suptitle(table.title, fontsize=12)
        figure.supxlabel(_LEGEND, fontsize=8)
    return figure


def colour_cells(axis: Axes, values: pd.DataFrame, norm: Normalize, square: bool = False) -> list[list[str]]:
    """Colour the cells of a table; the ink that is read on each, by row and column."""
    sns.heatmap(
        values, ax=axis, norm=norm, vmin=norm.vmin, vmax=norm.vmax, cmap=_COLOURS, cbar=False,
        square=square, linewidths=1.5, linecolor="white"
    )  # fmt: skip
    axis.tick_params(length=0)
    axis.set_yticklabels(axis.get_yticklabels(), rotation=0)
    colours = np.asarray(axis.collections[0].get_facecolor()).reshape(*values.shape, 4)
    lightness = colours[..., :3] @ (0.299, 0.587, 0.114)
    return [["black" if light > 0.5 else "white" for light in row] for row in lightness]


def colour_bar(figure: Figure, axes: list[Axes], norm: Normalize, **how: Any) -> Colorbar:
    """What the colours of the cells mean."""
    bar = figure.colorbar(plt.cm.ScalarMappable(norm=norm, cmap=_COLOURS), ax=axes, **how)
    bar.minorticks_off()
    return bar


def hatch(axis: Axes, x: int, y: int, note: str) -> None:
    """Mark a cell as not measured."""
    axis.add_patch(Rectangle((x, y), 1, 1, fill=False, hatch="///", edgecolor="0.6", linewidth=0))
    write(axis, x, y, [(0.5, note, {"bbox": {"facecolor": "white", "edgecolor": "none"}})], "black")


def save(figure: Figure, stem: Path, mark: str = "") -> list[Path]:
    """Write a figure as PNG and SVG, the same bytes for the same figure; a mark stands in its corner."""
    paths = []
    if mark:
        figure.text(0.98, 0.98, mark, ha="right", va="top", fontsize=8, color="#664d03", backgroundcolor="#fff3cd")
    with mpl.rc_context(SETTINGS):
        for suffix, metadata in ((".png", {}), (".svg", {"Date": None})):
            path = stem.with_name(f"{stem.name}{suffix}")
            figure.savefig(path, dpi=160, metadata=metadata)
            paths.append(path)
    plt.close(figure)
    return paths


def _annotate(
    axis: Axes, cells: pd.DataFrame, values: pd.DataFrame, row: str, column: str, inks: list[list[str]]
) -> None:
    """Write into every cell; hatch the ones that were not measured."""
    rows, columns = values.index.tolist(), values.columns.tolist()
    for cell in cells.to_dict("records"):
        y, x = rows.index(cell[row]), columns.index(cell[column])
        if np.isnan(cell["measured"]):
            hatch(axis, x, y, f"not measured\npaper {cell['paper']:,.0f}")
            continue
        lines: list[Line] = [
            (0.24, f"{cell['measured']:,.0f}", {"fontsize": 13, "fontweight": "bold"}),
            (0.44, interval_text(cell), {"fontsize": 8}),
            (0.62, f"paper {cell['paper']:,.0f}", {}),
            (0.77, f"ratio {cell['ratio']:.2f}", {}),
        ]
        failures = cell["failed_periods"]
        remark = "" if failures == 0 else f"failures {failures:.0%}" if failures >= 0.01 else "failures <1%"
        remark += " †" if cell["top_percent"] >= HEAVY_TAIL else ""
        lines.append((0.91, remark, {"fontsize": 8, "style": "italic"}))
        write(axis, x, y, lines, inks[y][x])


def write(axis: Axes, x: int, y: int, lines: list[Line], colour: str) -> None:
    """Write lines into a cell."""
    for height, text, style in lines:
        axis.text(x + 0.5, y + height, text, ha="center", va="center", color=colour, **style)
