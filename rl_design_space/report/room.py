"""Whether the text of a picture leaves room for its data."""

from __future__ import annotations

import warnings

from matplotlib.axes import Axes
from matplotlib.figure import Figure

_POINTS_PER_INCH = 72
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
