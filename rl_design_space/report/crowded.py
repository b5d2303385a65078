"""Text that overlaps, or has no room in its cell, once a picture has its size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Text

from rl_design_space.report.best_set import STAR

_UPRIGHT = 90
#: Points: least size of text in cells.
_SMALLEST = 4.0
#: Share of its cell that text may have, and letters between two names side by side.
_OF_CELL, _GAP = 0.94, 0.6


def part_ticks(figure: Figure) -> bool:
    """Turn names below an axis upright if they overlap, leave out what still does, and return whether names turned.

    Args:
        figure: the picture, after its parts have their places.
    """
    turned = False
    for axes in figure.axes:
        labels = [tick.label1 for tick in axes.xaxis.get_major_ticks() if tick.label1.get_text()]
        if not (axes.get_visible() and axes.axison) or {label.get_rotation() for label in labels} - {0, _UPRIGHT}:
            continue
        if not any(_touch(one, other) for one, other in pairwise(labels)):
            continue
        are_names = _is_table(axes) or any(letter.isalpha() for label in labels for letter in label.get_text())
        if are_names and not any(label.get_rotation() for label in labels):
            for label in labels:
                label.set(rotation=_UPRIGHT)
            turned = True
        _thin_out(labels)
    return turned


def fit_cells(figure: Figure) -> None:
    """Shrink text that is wider than its cell, all of a size alike; leave out what could not be read.

    Numbers that have no room are upright where cells are high enough, and alone. A star stays in any case.
    """
    for axes in figure.axes:
        if not _is_table(axes):
            continue
        (left, right), (below, above), room = axes.get_xlim(), axes.get_ylim(), axes.get_window_extent()
        width, height = _OF_CELL * room.width / abs(right - left), _OF_CELL * room.height / abs(above - below)
        sizes: dict[float, list[Text]] = {}
        for text in axes.texts:
            if text.get_text():
                sizes.setdefault(round(float(text.get_fontsize()), 3), []).append(text)
        ordered = sorted(sizes, reverse=True)
        for size in ordered:
            if _fit(sizes[size], size, width):
                continue
            if size == ordered[0] and _fit(sizes[size], size, height, width):
                for text in sizes[size]:
                    text.set(rotation=_UPRIGHT, y=int(text.get_position()[1]) + 0.5)
                for text in (each for other in ordered[1:] for each in sizes[other]):
                    text.set_visible(False)
                break
            for text in sizes[size]:
                text.set(text=STAR, fontsize=_SMALLEST, visible=STAR in text.get_text())


def _fit(texts: Sequence[Text], size: float, along: float, across: float = math.inf) -> bool:
    """Give texts of one size the largest at which all of them fit; return whether that can be read.

    Args:
        texts: the texts.
        size: of their letters, in points.
        along: room in the direction of their lines.
        across: room in the other direction.
    """
    boxes = [text.get_window_extent() for text in texts]
    fitting = size * min(1.0, *(along / box.width for box in boxes), *(across / box.height for box in boxes))
    if fitting < _SMALLEST:
        return False
    for text in texts:
        text.set_fontsize(fitting)
    return True


def _is_table(axes: Axes) -> bool:
    return bool(axes.texts) and any(isinstance(each, QuadMesh) for each in axes.collections)


def _touch(one: Text, other: Text) -> bool:
    gap = 0.0 if one.get_rotation() else _GAP * float(one.get_fontsize())
    return bool(one.get_window_extent().x1 + gap > other.get_window_extent().x0)


def _thin_out(labels: Sequence[Text]) -> None:
    """Hide labels that overlap the one before them that stays; both ends stay if they can."""
    last = labels[0]
    for label in labels[1:]:
        if _touch(last, label):
            label.set_visible(False)
        else:
            last = label
