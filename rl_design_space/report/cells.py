"""Cells of heatmaps: colours, text inside, and hatching where nothing was measured."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from rl_design_space.report.coloured_cells import draw_cells
from rl_design_space.report.look import COLOURS

_HATCH: dict[str, Any] = {"hatch": "///", "fill": False, "edgecolor": "0.6"}

#: Label of an axis whose patches are cells of a side of 1, and whose annotations are headings of groups of columns.
CELLS = "cells"
#: Height within the cell, text, and its style.
Line = tuple[float, str, dict[str, Any]]


def colour_cells(
    axis: Axes, values: pd.DataFrame, norm: Normalize, square: bool = False, colour_map: str = COLOURS
) -> list[list[str]]:
    """Colour the cells of a table.

    Args:
        axis: to draw on.
        values: of the cells; NaN stays white.
        norm: scale of the colours.
        square: whether cells are as high as they are wide.
        colour_map: name of the colours.

    Returns:
        The colour of text that can be read on each cell, by row and column.
    """
    if square:
        axis.set_aspect("equal")
    mesh = draw_cells(axis, values, norm, colour_map, line_width=1.5)
    axis.tick_params(length=0)
    mesh.update_scalarmappable()
    colours = np.asarray(mesh.get_facecolor()).reshape(*values.shape, 4)
    lightness = colours[..., :3] @ (0.299, 0.587, 0.114)
    return [["black" if light > 0.5 else "white" for light in row] for row in lightness]


def colour_bar(figure: Figure, axes: list[Axes], norm: Normalize, colour_map: str = COLOURS, **how: Any) -> Colorbar:
    """Draw the scale of the colours beside axes; `how` goes to `Figure.colorbar`."""
    bar = figure.colorbar(plt.cm.ScalarMappable(norm=norm, cmap=colour_map), ax=axes, **how)
    bar.minorticks_off()
    return bar


def write(axis: Axes, x: int, y: int, lines: Iterable[Line], colour: str = "black") -> None:
    """Write lines of text into a cell."""
    for height, text, style in lines:
        axis.text(x + 0.5, y + height, text, ha="center", va="center", color=colour, **style)


def hatch(axis: Axes, x: int, y: int, note: str) -> None:
    """Hatch a cell that was not measured, with a note in its middle."""
    axis.add_patch(Rectangle((x, y), 1, 1, linewidth=0, **_HATCH))
    write(axis, x, y, [(0.5, note, {"bbox": {"facecolor": "white", "edgecolor": "none"}})])


def hatch_row(axis: Axes, y: int, note: str) -> None:
    """Hatch a row that was not measured, from one side of an axis to the other, with a note in its middle."""
    across = axis.get_yaxis_transform()
    axis.barh(y, 1, height=0.6, transform=across, **_HATCH)
    axis.text(0.5, y, note, transform=across, ha="center", va="center", backgroundcolor="w")
