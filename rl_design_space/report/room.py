"""Whether the text of a picture leaves room for its data."""

from __future__ import annotations

import warnings

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

_POINTS_PER_INCH = 72
#: Points between text and the sides of a picture; the layout leaves 3 where it knows the width of the text.
_MARGIN = 2.0
#: Least side of an axis over the size of its text.
_LEAST = 3.0
#: What Matplotlib says if an axis has no room at all.
_COLLAPSED = "constrained_layout not applied"


def has_room(figure: Figure) -> bool:
    """Return whether each axis of a picture is larger than a few letters of its text; find the places of all parts."""
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=_COLLAPSED)
        try:
            figure.draw_without_rendering()
        except UserWarning:
            return False
    return all(_side(axes) >= _LEAST * _text_size(axes) for axes in figure.axes if _shows_data(axes))


def cut_empty_height(figure: Figure) -> bool:
    """Cut the height that axes of a fixed aspect leave empty, once all parts have their places; return whether any."""
    empty = min((_empty(axes) for axes in figure.axes if _shows_data(axes)), default=0.0)
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height - empty)
    return empty > 0


def keep_inside(figure: Figure) -> None:
    """Make room for text that is cut at the sides, once all parts have their places, if that leaves room for the data.

    The layout takes text that is wider than its axis for narrower than it is.
    """
    engine = figure.get_layout_engine()
    if not isinstance(engine, ConstrainedLayoutEngine):
        return
    for _ in range(2):  # what is narrower now may be wider than its axis by more
        rect = x, y, width, height = engine.get()["rect"]
        left, right = _cut(figure)
        if not left and not right:
            return
        engine.set(rect=(x + left, y, width - left - right, height))
        if not has_room(figure):
            engine.set(rect=rect)
            has_room(figure)
            return


def _cut(figure: Figure) -> tuple[float, float]:
    """Return the shares of the width by which axes with their text leave a picture on the left and right."""
    width, margin = figure.bbox.width, _MARGIN * figure.dpi / _POINTS_PER_INCH
    boxes = [box for axes in figure.axes if (box := axes.get_tightbbox()) is not None]
    fitting = [box for box in boxes if box.width + 2 * margin < width]
    left = max((margin - box.x0 for box in fitting), default=0.0)
    right = max((box.x1 + margin - width for box in fitting), default=0.0)
    return max(left, 0.0) / width, max(right, 0.0) / width


def _empty(axes: Axes) -> float:
    """Return the inches above and below an axis and its text, of those that it was given."""
    figure = axes.get_figure(root=True)
    needed = axes.get_tightbbox()
    if figure is None or needed is None:
        return 0.0
    given = axes.get_position(original=True).transformed(figure.transSubfigure)
    return float(max(0.0, given.y1 - needed.y1) + max(0.0, needed.y0 - given.y0)) / figure.dpi


def _shows_data(axes: Axes) -> bool:
    """Return whether an axis is part of the picture, not the bar of colours beside one."""
    return axes.get_visible() and axes.axison and not hasattr(axes, "_colorbar") and axes.get_subplotspec() is not None


def _side(axes: Axes) -> float:
    """Return the shorter side of an axis in points."""
    box, dots = axes.get_window_extent(), axes.get_figure(root=True).dpi  # type: ignore[union-attr]
    return float(min(box.width, box.height)) * _POINTS_PER_INCH / dots


def _text_size(axes: Axes) -> float:
    """Return the size of the smaller text beside an axis."""
    ticks = [axis.get_major_ticks()[:1] for axis in (axes.xaxis, axes.yaxis)]
    return min((float(tick.label1.get_fontsize()) for each in ticks for tick in each), default=0.0)
