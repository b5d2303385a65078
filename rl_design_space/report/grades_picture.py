"""A graded table as a heatmap, and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

import matplotlib.pyplot as plt
import seaborn as sns
from matplotlib.patches import Rectangle

from rl_design_space.report.grades import GRADES, Cell, Grading

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SETTINGS: dict[Any, Any] = {"svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "font.size": 9}
#: Much is dark; even in lightness, so that it reads in grey.
_COLOURS = ["#123a6b", "#5b86b8", "#b9cfe4", "#f2f2ee"]
_NOTE = (
    "Large: our grade, from the number below it with its 95 % interval. Framed in orange: the paper's grade is another "
    "one.\nHatched: missing, or judged by the paper and not to be measured."
)


def draw(cells: Sequence[Cell], title: str, labels: Mapping[str, str]) -> Figure:
    """Rows by columns, coloured by our grade.

    Args:
        cells: of the table.
        title: of the picture.
        labels: how names read.
    """
    rows, columns = (list(dict.fromkeys(getattr(cell, side) for cell in cells)) for side in ("row", "column"))
    shade = np.full((len(rows), len(columns)), np.nan)
    for cell in cells:
        if cell.grade:
            shade[rows.index(cell.row), columns.index(cell.column)] = GRADES.index(cell.grade)
    with mpl.rc_context(_SETTINGS):
        figure, axis = plt.subplots(figsize=(1.4 + 2.5 * len(columns), 1.5 + 1.25 * len(rows)), layout="constrained")
        sns.heatmap(
            shade, ax=axis, cmap=_COLOURS, vmin=-0.5, vmax=len(GRADES) - 0.5, cbar=False, linewidths=2,
            linecolor="white", xticklabels=[labels.get(c, c) for c in columns],
            yticklabels=[labels.get(r, r) for r in rows],
        )  # fmt: skip
        for cell in cells:
            _annotate(axis, cell, rows.index(cell.row), columns.index(cell.column))
        axis.tick_params(length=0, labelsize=10)
        axis.xaxis.tick_top()
        axis.set_yticklabels(axis.get_yticklabels(), rotation=0)
        figure.suptitle(title, fontsize=12)
        figure.supxlabel(_NOTE, fontsize=8)
    return figure


def _annotate(axis: Any, cell: Cell, y: int, x: int) -> None:
    paper = f"paper: {cell.paper}" if cell.paper else ""
    if not cell.grade:
        axis.add_patch(Rectangle((x, y), 1, 1, fill=False, hatch="///", edgecolor="0.7", linewidth=0))
        box = {"facecolor": "white", "edgecolor": "none"}
        axis.text(x + 0.5, y + 0.5, f"{cell.text}\n{paper}".strip(), ha="center", va="center", bbox=box)
        return
    ink = "white" if cell.grade in GRADES[:2] else "black"
    axis.text(x + 0.5, y + 0.22, cell.grade, ha="center", va="center", color=ink, fontsize=15, fontweight="bold")
    axis.text(x + 0.5, y + 0.56, cell.text, ha="center", va="center", color=ink, fontsize=8)
    axis.text(x + 0.5, y + 0.87, paper, ha="center", va="center", color=ink, fontsize=8, style="italic")
    if cell.paper and cell.paper != cell.grade:
        axis.add_patch(Rectangle((x + 0.03, y + 0.03), 0.94, 0.94, fill=False, edgecolor="#e07b00", linewidth=2))


def table_lines(cells: Sequence[Cell], gradings: Mapping[str, Grading], labels: Mapping[str, str]) -> list[str]:
    """The table and the rules of its grades, in Markdown."""
    rows, columns = (list(dict.fromkeys(getattr(cell, side) for cell in cells)) for side in ("row", "column"))
    by_place = {(cell.row, cell.column): cell for cell in cells}
    lines = [f"| | {' | '.join(labels.get(c, c) for c in columns)} |", f"|---|{'---|' * len(columns)}"]
    for row in rows:
        texts = []
        for column in columns:
            cell = by_place[row, column]
            paper = f"; paper {cell.paper}" if cell.paper else ""
            texts.append(f"{f'**{cell.grade}** ' if cell.grade else ''}{' '.join(cell.text.split())}{paper}")
        lines.append(f"| {labels.get(row, row)} | {' | '.join(texts)} |")
    rules = [f"- **{labels.get(name, name)}**: {each.means}. {each.rule()}." for name, each in gradings.items()]
    return [*lines, "", *rules, ""]
