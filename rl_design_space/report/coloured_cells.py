"""Cells coloured by their values, with names beside them, as `seaborn.heatmap` draws them.

To import seaborn takes a second and a half, and its heatmap draws the whole figure once to see which names overlap.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.text import Text

_POINTS_PER_INCH = 72


def draw_cells(
    axis: Axes, values: pd.DataFrame, norm: Normalize, colour_map: str | Colormap, line_width: float
) -> QuadMesh:
    """Draw a table, its first row on top, with the names of columns and rows.

    Of names that are too many for their size, every second or third one is written.

    Args:
        axis: to draw on.
        values: of the cells; NaN stays white.
        norm: scale of the colours.
        colour_map: the colours, or their name.
        line_width: of the white lines between cells, in points.
    """
    axis.spines[:].set_visible(False)
    numbers = values.to_numpy(np.float64)
    cells = np.ma.masked_where(np.isnan(numbers), numbers)
    mesh = axis.pcolormesh(cells, cmap=colour_map, norm=norm, linewidths=line_width, edgecolor="white")
    axis.set(xlim=(0, values.shape[1]), ylim=(values.shape[0], 0))
    room, dpi = axis.get_window_extent(), _figure(axis).dpi
    _name(axis.xaxis, [str(name) for name in values.columns], room.width / dpi)
    _name(axis.yaxis, [str(name) for name in values.index], room.height / dpi)
    _turn_what_overlaps(axis)
    axis.set(xlabel=values.columns.name or "", ylabel=values.index.name or "")
    return mesh


def _name(axis: Axis, names: Sequence[str], inches: float) -> None:
    """Write names beside rows or columns, as many as there is room for."""
    (tick,) = axis.set_ticks([0])
    most = int(inches // (float(tick.label1.get_fontsize()) / _POINTS_PER_INCH))
    every = len(names) // most + 1 if most else len(names) + 1
    places = np.arange(len(names))[::every] if most else np.arange(0)
    axis.set_ticks((places + 0.5).tolist(), [names[place] for place in places])


def _turn_what_overlaps(axis: Axes) -> None:
    """Turn names of columns upright if they overlap where the layout of the figure puts them.

    Names of rows are upright until then, as in seaborn, which decides on the room that columns have.
    """
    for name in axis.get_yticklabels():
        name.set(rotation="vertical", va="center")
    figure = _figure(axis)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    columns, rows = axis.get_xticklabels(), axis.get_yticklabels()
    if _overlap(columns):
        for name in columns:
            name.set(rotation="vertical")
    for name in rows:
        name.set(rotation="horizontal")


def _figure(axis: Axes) -> Figure:
    figure = axis.get_figure(root=True)
    assert figure is not None
    return figure


def _overlap(names: Sequence[Text]) -> bool:
    boxes = [name.get_window_extent() for name in names]
    return any(box.count_overlaps(boxes) > 1 for box in boxes)
