"""The picture of a graded table: its cells, and below them the grades by other definitions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure, FigureBase
from matplotlib.patches import Rectangle

from rl_design_space.report.cells import CELLS, Line, hatch, write
from rl_design_space.report.coloured_cells import draw_cells
from rl_design_space.report.definitions import in_order
from rl_design_space.report.grading import GRADES
from rl_design_space.report.style import FRAME, GREEN, GREY, VERMILION, number, styled

#: Much is dark; even in lightness, so that it can be read in grey.
_COLOURS = ["#123a6b", "#5b86b8", "#b9cfe4", "#f2f2ee"]
#: Signs of the verdicts on orders, and their colours.
_SIGNS = {"some limits": ("✓", GREEN), "no limits": ("✗", VERMILION), "cannot be told": ("?", GREY)}
#: Width and height of a cell of the grid, and width of the names beside it, in inches.
_CELL, _ROW, _NAMES = 0.6, 0.42, 3.0
_LARGE = "Large: measured grade, from the number below it with its 95 % interval."


@styled()
def draw_table(
    cells: pd.DataFrame, definitions: pd.DataFrame | None, title: str, labels: Mapping[str, str], source: str
) -> Figure:
    """Draw rows by columns, coloured by grade, and the grades by other definitions below them, if there are any.

    Args:
        cells: row, column, grade, paper and measured.
        definitions: see `report.definitions.defined`.
        title: of the picture.
        labels: how names of rows and columns read.
        source: what the published grades are called.
    """
    rows, columns = cells["row"].unique(), cells["column"].unique()
    width, height = 1.4 + 2.5 * len(columns), 1.5 + 1.25 * len(rows)
    if definitions is None or not (definitions["under"] != "").any():
        figure = plt.figure(figsize=(width, height), layout="constrained")
        _draw_cells(figure, cells, labels, source)
    else:
        definitions = in_order(definitions)
        lines = len(definitions.drop_duplicates(["column", "definition"])) + definitions["column"].nunique()
        below = 1.6 + _ROW * lines
        width = max(width, _NAMES + _CELL * (len(rows) + 1) * len(_settings(definitions)))
        figure = plt.figure(figsize=(width, height + below), layout="constrained")
        grid = figure.add_gridspec(2, 1, height_ratios=[height, below])
        upper, lower = (figure.add_subfigure(grid[place]) for place in range(2))
        _draw_cells(upper, cells, labels, source)
        _draw_definitions(lower, definitions, labels, source)
    figure.suptitle(title, fontsize=12)
    return figure


def _draw_cells(figure: FigureBase, cells: pd.DataFrame, labels: Mapping[str, str], source: str) -> None:
    rows, columns = list(cells["row"].unique()), list(cells["column"].unique())
    shade = np.full((len(rows), len(columns)), np.nan)
    for cell in cells[cells["grade"] != ""].to_dict("records"):
        shade[rows.index(cell["row"]), columns.index(cell["column"])] = GRADES.index(cell["grade"])
    axis = figure.subplots()
    shown = [labels.get(row, row) for row in rows], [labels.get(column, column) for column in columns]
    norm = Normalize(-0.5, len(GRADES) - 0.5)
    draw_cells(axis, pd.DataFrame(shade, *shown), norm, ListedColormap(_COLOURS), line_width=2)
    for cell in cells.to_dict("records"):
        _write_cell(axis, cell, columns.index(cell["column"]), rows.index(cell["row"]), source)
    axis.tick_params(length=0, labelsize=10)
    axis.xaxis.tick_top()
    compared = bool((cells["paper"] != "").any())
    framed = f' Framed in orange: the grade differs from the one after "{source}:".' if compared else ""
    figure.supxlabel(f"{_LARGE}{framed}\nHatched: missing or not measured.", fontsize=8)


def _write_cell(axis: Axes, cell: dict[Any, Any], x: int, y: int, source: str) -> None:
    grade, text = cell["grade"], cell["measured"]
    published = f"{source}: {cell['paper']}" if cell["paper"] else ""
    if not grade:
        hatch(axis, x, y, f"{text}\n{published}".strip())
        return
    lines: list[Line] = [
        (0.22, grade, {"fontsize": 15, "fontweight": "bold"}),
        (0.56, text, {"fontsize": 8}),
        (0.87, published, {"fontsize": 8, "style": "italic"}),
    ]
    write(axis, x, y, lines, _readable(grade))
    if cell["paper"] and cell["paper"] != grade:
        axis.add_patch(Rectangle((x + 0.03, y + 0.03), 0.94, 0.94, fill=False, edgecolor=FRAME, linewidth=2))


def _readable(grade: str) -> str:
    """Return the colour of text on the colour of a grade."""
    return "white" if grade in GRADES[:2] else "black"


def _draw_definitions(figure: FigureBase, definitions: pd.DataFrame, labels: Mapping[str, str], source: str) -> None:
    """Draw a line for each definition, grouped by column; in it a block of rows for each setting, and the verdict."""
    rows = list(definitions["row"].unique())
    settings = _settings(definitions)
    wide = len(rows) + 1
    axis = figure.subplots(subplot_kw={"label": CELLS})
    ticks: list[tuple[float, str, bool]] = []
    y = 0
    for column, of_column in definitions.groupby("column", sort=False):
        ticks.append((y + 0.5, f"{labels.get(str(column), str(column))}, {source}:", True))
        published = of_column.drop_duplicates("row").set_index("row")["paper"]
        for x, row in enumerate(rows):
            write(axis, x, y, [(0.5, published.get(row, ""), {"style": "italic"})])
        y += 1
        for name, of_name in of_column.groupby("definition", sort=False):
            ticks.append((y + 0.5, str(name), False))
            for under, block in of_name.groupby("under", sort=False):
                left = wide * settings.index(str(under)) if under else 0
                for cell in block.to_dict("records"):
                    _write_grade(axis, cell, left + rows.index(cell["row"]), y)
                sign, colour = _SIGNS.get(block["order"].iloc[0], ("", GREY))
                write(axis, left + len(rows), y, [(0.5, sign, {"fontsize": 12, "fontweight": "bold"})], colour)
            y += 1
    axis.set_xlim(0, wide * len(settings))
    axis.set_ylim(y, 0)
    axis.set_yticks([at for at, _, _ in ticks], [text for _, text, _ in ticks])
    for tick, (_, _, heading) in zip(axis.get_yticklabels(), ticks, strict=True):
        tick.set_fontweight("bold" if heading else "normal")
    short = [labels.get(row, row) for row in rows]
    axis.set_xticks(
        [wide * place + x + 0.5 for place in range(len(settings)) for x in range(len(rows))],
        short * len(settings),
        fontsize=8,
    )
    axis.xaxis.tick_top()
    for place, under in enumerate(settings):
        middle = wide * place + len(rows) / 2
        axis.annotate(
            under.replace(", ", ",\n"), (middle, 1), xycoords=("data", "axes fraction"), xytext=(0, 20),
            textcoords="offset points",
            ha="center", va="bottom", fontweight="bold",
        )  # fmt: skip
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
    figure.supxlabel(
        "✓ some limits would give the published order of the rows, ✗ no limits would, ? cannot be told.\n"
        'A line "registered" with one block only is that of the cells above.',
        fontsize=8,
    )


def _settings(definitions: pd.DataFrame) -> list[str]:
    return [under for under in definitions["under"].unique() if under]


def _write_grade(axis: Axes, cell: dict[Any, Any], x: int, y: int) -> None:
    """Write grade and number of a row by a definition into a cell of its colour."""
    grade = cell["grade"]
    if not grade:
        write(axis, x, y, [(0.5, "–", {})], GREY)
        return
    face = _COLOURS[GRADES.index(grade)]
    axis.add_patch(Rectangle((x + 0.03, y + 0.05), 0.94, 0.9, facecolor=face, edgecolor="none"))
    never = "≥ " if cell["measured"].startswith("≥") else ""
    lines: list[Line] = [
        (0.3, grade, {"fontsize": 9, "fontweight": "bold"}),
        (0.7, f"{never}{number(cell['number'])}", {"fontsize": 8}),
    ]
    write(axis, x, y, lines, _readable(grade))
