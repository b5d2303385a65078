"""Text that overlaps, or has no room in its cell, once a picture has its size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

from rl_design_space.report.best_set import STAR
from rl_design_space.report.cells import CELLS

_UPRIGHT = 90
_POINTS_PER_INCH = 72
#: Points: least size of text in cells.
_SMALLEST = 4.0
#: Share of its cell that text may have, without the lines between cells; letters between two names side by side.
_OF_CELL, _GAP = 0.88, 0.6


def part_ticks(figure: Figure) -> bool:
    """Break names beside an axis if they overlap, or turn them upright, and leave out what still overlaps.

    Headings of groups of columns, which are above their names, are turned and raised likewise.

    Args:
        figure: the picture, after its parts have their places.

    Returns:
        Whether names need another height.
    """
    turned = False
    for axes in figure.axes:
        labels = _shown(axes)
        if not (axes.get_visible() and axes.axison) or {label.get_rotation() for label in labels} - {0, _UPRIGHT}:
            continue
        turned |= _turn_headings(axes)
        if not any(_touch(one, other) for one, other in pairwise(labels)):
            continue
        before = _height(labels)
        are_names = _is_table(axes) or any(letter.isalpha() for label in labels for letter in label.get_text())
        if are_names and any(" " in label.get_text() for label in labels):
            names = [label.get_text().replace(" ", "\n") for label in labels]
            axes.xaxis.set_ticks(axes.xaxis.get_ticklocs(), names)
            labels, turned = _shown(axes), True
            _raise_headings(axes, _height(labels) - before)
            if not any(_touch(one, other) for one, other in pairwise(labels)):
                continue
        if are_names and not any(label.get_rotation() for label in labels):
            before = _height(labels)
            for label in labels:
                label.set(rotation=_UPRIGHT)
            if any(_touch(one, other) for one, other in pairwise(labels)):  # names in one line are narrower now
                names = [label.get_text().replace("\n", " ") for label in labels]
                axes.xaxis.set_ticks(axes.xaxis.get_ticklocs(), names)
                labels = _shown(axes)
            _raise_headings(axes, _height(labels) - before)
            turned = True
        _thin_out(labels)
    return turned


def _shown(axes: Axes) -> list[Text]:
    """Return the labels of the ticks that are below an axis, or above it where nothing else is written."""
    top = axes.get_window_extent().y1
    is_free = not any(text.get_window_extent().y0 > top for text in axes.texts if not isinstance(text, Annotation))
    ticks = axes.xaxis.get_major_ticks()
    labels = [label for tick in ticks for label in (tick.label1, *([tick.label2] if is_free else []))]
    return [label for label in labels if label.get_visible() and label.get_text()]


def _headings(axes: Axes) -> list[Annotation]:
    """Return the headings of groups of columns, from left to right."""
    found = [text for text in axes.texts if isinstance(text, Annotation)] if axes.get_label() == CELLS else []
    return sorted(found, key=lambda text: text.xy[0])


def _turn_headings(axes: Axes) -> bool:
    """Turn the headings of groups of columns upright if they overlap; return whether they do."""
    headings = _headings(axes)
    if not any(_touch(one, other) for one, other in pairwise(headings)):
        return False
    for heading in headings:
        heading.set(rotation=_UPRIGHT)
    return True


def _raise_headings(axes: Axes, higher: float) -> None:
    """Move the headings of groups of columns up, by pixels."""
    for heading in _headings(axes):
        x, y = heading.xyann
        heading.xyann = (x, y + higher * _POINTS_PER_INCH / axes.get_figure(root=True).dpi)  # type: ignore[union-attr]


def _height(labels: Sequence[Text]) -> float:
    """Return the height of the highest of these texts in pixels."""
    return max(float(label.get_window_extent().height) for label in labels)


def fit_cells(figure: Figure) -> None:
    """Shrink text that is wider than its cell; leave out what could not be read.

    The largest text, which is the number of a cell, is of one size in all cells. Where it has no room, it is upright
    if cells are high enough, and alone. A star stays in any case. In tables whose rows are different numbers, a row has
    its numbers if all of them can be read. A text that is alone in its cell now moves to the middle.
    """
    for axes in figure.axes:
        if not _is_table(axes):
            continue
        (left, right), (below, above), room = axes.get_xlim(), axes.get_ylim(), axes.get_window_extent()
        width, height = _OF_CELL * room.width / abs(right - left), _OF_CELL * room.height / abs(above - below)
        lines = _by_line([text for text in axes.texts if text.get_text() and not isinstance(text, Annotation)])
        numbers, *others = [lines[line] for line in sorted(lines, reverse=True)]
        if not _fit(numbers, width):
            if _fit(numbers, height, width):
                for text in numbers:
                    text.set(rotation=_UPRIGHT, y=int(text.get_position()[1]) + 0.5)
            else:
                for text in numbers:
                    text.set(text=STAR, fontsize=_SMALLEST, visible=STAR in text.get_text())
            for text in (each for line in others for each in line):
                text.set_visible(False)
            continue
        each_row = axes.get_label() == CELLS
        for line in (part for other in others for part in (_rows(other) if each_row else [other])):
            fitting = [_fit([text], width) for text in line]
            for text, fits in zip(line, fitting, strict=True):
                text.set_visible(all(fitting) if each_row else fits and 2 * sum(fitting) >= len(line))
        _centre([text for line in lines.values() for text in line])


def _centre(texts: Sequence[Text]) -> None:
    """Move the text that is left of a cell with several to the middle of the cell."""
    cells: dict[tuple[int, int], list[Text]] = {}
    for text in texts:
        x, y = text.get_position()
        cells.setdefault((math.floor(x), math.floor(y)), []).append(text)
    for (_, y), written in cells.items():
        left = [text for text in written if text.get_visible()]
        if len(left) == 1 < len(written):
            left[0].set(y=y + 0.5)


def _by_line(texts: Sequence[Text]) -> dict[tuple[float, float], list[Text]]:
    """Return texts by their size and height within a cell."""
    lines: dict[tuple[float, float], list[Text]] = {}
    for text in texts:
        size, height = round(float(text.get_fontsize()), 3), round(float(text.get_position()[1]) % 1, 3)
        lines.setdefault((size, height), []).append(text)
    return lines


def _rows(texts: Sequence[Text]) -> list[list[Text]]:
    """Return texts by the row of their cells."""
    rows: dict[int, list[Text]] = {}
    for text in texts:
        rows.setdefault(int(text.get_position()[1]), []).append(text)
    return list(rows.values())


def _fit(texts: Sequence[Text], along: float, across: float = math.inf) -> bool:
    """Give texts the largest size, of all of them, at which they fit; return whether that can be read.

    Args:
        texts: the texts, of one size.
        along: room in the direction of their lines.
        across: room in the other direction.
    """
    size, boxes = float(texts[0].get_fontsize()), [text.get_window_extent() for text in texts]
    fitting = size * min(1.0, *(along / box.width for box in boxes), *(across / box.height for box in boxes))
    if fitting < _SMALLEST:
        return False
    for text in texts:
        text.set_fontsize(fitting)
    return True


def _is_table(axes: Axes) -> bool:
    has_cells = axes.get_label() == CELLS or any(isinstance(each, QuadMesh) for each in axes.collections)
    return has_cells and bool(axes.texts)


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
