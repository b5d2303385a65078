"""Pictures in a size that was asked for: sides, text, and what would leave no room for the data."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure, FigureBase
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation

from rl_design_space.errors import ConfigError
from rl_design_space.report.crowded import fit_cells, part_ticks
from rl_design_space.report.room import cut_empty_height, has_room, keep_inside

#: Points: size of most text in pictures of their own size, and the least that it shrinks to by itself.
USUAL, SMALLEST = 9.0, 6.0
_POINTS_PER_INCH = 72
#: Shares of the width: of names beside an axis, at most, and of a legend beside it, from which on it is put below.
_NAMES, _LEGEND = 0.42, 0.4
#: Width of a letter over the size of its text, on average; distance of lines; lines between an axis and a legend below.
_LETTER, _LINE, _BELOW = 0.52, 1.3, 3.6
#: Lines that are free between names of several lines.
_BETWEEN = 0.6
#: Height from which on a legend is above its axis, as a share of the axis.
_ABOVE = 0.99
#: Share of the width that names in a legend below an axis have.
_BELOW_WIDTH = 0.85
#: Share of the height or width of its part of the picture that an axis has.
_OF_PART = 0.75
#: A space that is no place for a line break.
_FIXED = "\u00a0"


def fit(figure: Figure, width: float | None, height: float | None, font_size: float | None) -> None:
    """Bring a picture to a size; what is None follows from the rest.

    Text shrinks with the width, but not below 6 points, and never grows by itself. A picture is only lower than it was
    as far as its text is smaller, so that rows of text do not overlap, and higher by the legends that are put below.
    What square cells leave empty above and below them is cut.

    Args:
        figure: the picture, before it was drawn on a canvas.
        width: inches.
        height: inches.
        font_size: points of most text; other text is in proportion.

    Raises:
        ConfigError: the size leaves no room for the data beside the text.
    """
    if width is None and height is None and font_size is None:
        return
    before = figure.get_size_inches()
    narrower = width / before[0] if width else 1.0
    text = font_size / USUAL if font_size else min(1.0, max(narrower, SMALLEST / USUAL))
    higher = max(narrower, min(1.0, text)) if width else 1.0
    figure.set_size_inches(width or before[0], height or before[1] * higher)
    _resize_text(figure, text)
    if (title := figure._suptitle) is not None:  # type: ignore[attr-defined]
        title.set_text(title.get_text().replace("\n", " "))  # its lines were those of another width
    make_room(figure, may_grow=height is None)
    # Names that turn need more room, which there may not be.
    if not has_room(figure) or (part_ticks(figure) and not has_room(figure)):
        raise _no_room(before.tolist(), width, height, font_size)
    if _break_long_labels(figure) and not has_room(figure):
        raise _no_room(before.tolist(), width, height, font_size)
    if height is None and cut_empty_height(figure):
        has_room(figure)
    keep_inside(figure)
    fit_cells(figure)


def _no_room(own: list[float], width: float | None, height: float | None, font_size: float | None) -> ConfigError:
    """Return an error that names what was asked for, and the picture's own size."""
    problem = "leaves no room for the data beside the text of this picture; should be"
    if font_size and font_size > USUAL:
        return ConfigError.at("font_size", f"{font_size:g}", f"{problem} less; {USUAL:g} is usual")
    name, value, usual = ("width", width, own[0]) if width else ("height", height or 0.0, own[1])
    return ConfigError.at(name, f"{value:g}", f"{problem} more; its own {name} is {usual:.3g} inches")


def make_room(figure: Figure, *, may_grow: bool = True) -> None:
    """Put wide legends below their axes, and break long names, headings and labels into lines.

    Args:
        figure: the picture.
        may_grow: whether it becomes higher if that needs more room.
    """
    needed = [max(_break_names(axes), _put_legend_aside(axes)) for axes in figure.axes]
    if may_grow and needed:
        width, height = figure.get_size_inches()
        figure.set_size_inches(width, height + max(needed))
    _break([*_headings(figure), *_labels(figure)])
    for axes in figure.axes:
        _put_below_label(axes)


def break_headings(figure: Figure) -> None:
    """Break the heading and the note of a picture into lines that are not longer than it is wide."""
    _break(_headings(figure))


def _put_legend_aside(axes: Axes) -> float:
    """Put a legend that is wide below its axis; return its height in inches, 0 if it stays.

    A legend over the data is wide if it covers much of the axis, and stays if something is below the axis.
    """
    legend, figure = axes.get_legend(), axes.get_figure(root=True)
    if legend is None or figure is None:
        return 0.0
    size = float(legend.get_texts()[0].get_fontsize()) if legend.get_texts() else 0.0
    longest = max((len(text.get_text()) for text in legend.get_texts()), default=0)
    anchor = legend.get_bbox_to_anchor().transformed(axes.transAxes.inverted())
    if anchor.y0 < 0:
        return 0.0
    if anchor.y0 > _ABOVE and anchor.x0 < 1:
        return _break_legend(legend, figure, size)
    room = figure.get_size_inches()[0]
    if anchor.x0 < 1:
        room *= _share(axes)[0] - (_NAMES if _names(axes.yaxis) else 0)
        if not _is_last(axes) or not size:
            return 0.0
    if _inches(longest + 6, size) < _LEGEND * room:
        return 0.0
    legend.set_bbox_to_anchor((0.5, -0.1), transform=axes.transAxes)
    _break_legend(legend, figure, size)
    lines = sum(text.get_text().count("\n") + 1 for text in legend.get_texts())
    return lines * _LINE * size / _POINTS_PER_INCH


def _break_legend(legend: Legend, figure: Figure, size: float) -> float:
    """Break names of a legend that are wider than the picture into lines; return the height of new lines in inches."""
    before = [text.get_text() for text in legend.get_texts()]
    for text in legend.get_texts():
        text.set_text(_broken(text.get_text(), _BELOW_WIDTH * figure.get_size_inches()[0], size))
    lines = sum(text.get_text().count("\n") for text in legend.get_texts()) - sum(name.count("\n") for name in before)
    return lines * _LINE * size / _POINTS_PER_INCH


def _put_below_label(axes: Axes) -> None:
    """Put a legend that is below its axis below the label of the axis, too, however many lines that has."""
    legend, figure = axes.get_legend(), axes.get_figure(root=True)
    if legend is None or figure is None:
        return
    if legend.get_bbox_to_anchor().transformed(axes.transAxes.inverted()).y0 >= 0:
        return
    size = float(axes.xaxis.label.get_fontsize())
    lines = (_BELOW + _LINE * axes.xaxis.label.get_text().count("\n")) * size / _POINTS_PER_INCH
    legend.set_loc("upper center")
    legend.set_bbox_to_anchor((0.5, 0), transform=axes.transAxes + ScaledTranslation(0, -lines, figure.dpi_scale_trans))


def _inches(letters: int, size: float) -> float:
    return letters * _LETTER * size / _POINTS_PER_INCH


def _broken(text: str, inches: float, size: float) -> str:
    """Return a text with line breaks, so that it is about as wide."""
    letters = max(int(inches * _POINTS_PER_INCH / (_LETTER * size)), 8)
    return "\n".join(part for line in text.split("\n") for part in _wrapped(line, letters) or [""])


def _wrapped(line: str, letters: int, *, break_long_words: bool = True) -> list[str]:
    """Return lines of at most so many letters; a number and its sign of percent, and a ratio, stay together."""
    whole = line.replace(" %", f"{_FIXED}%").replace(" / ", f"{_FIXED}/{_FIXED}")
    return [part.replace(_FIXED, " ") for part in textwrap.wrap(whole, letters, break_long_words=break_long_words)]


def _break_long_labels(figure: Figure) -> bool:
    """Break labels that are longer than the height of their axis, now that it is known; return whether any are."""
    found = False
    for axes in figure.axes:
        label, room = axes.yaxis.label, float(axes.get_window_extent().height)
        words = label.get_text().replace("\n", " ")
        if not words or label.get_window_extent().height <= room:
            continue
        longest = max(map(len, label.get_text().split("\n")))
        letters = int(longest * room / label.get_window_extent().height)
        label.set_text("\n".join(_wrapped(words, max(letters, 8), break_long_words=False)))
        found = True
    return found


def _resize_text(figure: Figure, factor: float) -> None:
    texts = figure.findobj(Text)
    axes_ = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    ticks = [(axis, [*axis.get_major_ticks(), *axis.get_minor_ticks()]) for axis in axes_]
    labels = {id(label) for _, each in ticks for tick in each for label in (tick.label1, tick.label2)}
    for artist in texts:
        assert isinstance(artist, Text)
        if id(artist) not in labels:
            artist.set_fontsize(float(artist.get_fontsize()) * factor)
    for axis, each in ticks:
        if each:  # ticks that are made later have it, too
            axis.set_tick_params(which="both", labelsize=float(each[0].label1.get_fontsize()) * factor)


def _break_names(axes: Axes) -> float:
    """Break long names on the left of an axis into lines; return the inches by which the picture is then too low."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    names = _names(axes.yaxis)
    if not names:
        return 0.0
    width, height = figure.get_size_inches()
    size = float(axes.yaxis.get_major_ticks()[0].label1.get_fontsize())
    # Of that of its part of the picture, unless a word needs more.
    word = _inches(max(len(word) for name in names for word in name.split()) + 1, size)
    inches = _NAMES * width * max(_share(axes)[0], min(1.0, word / (_NAMES * width)))
    broken = [_broken(name, inches, size) for name in names]
    if broken != names:
        axes.yaxis.set_ticks(axes.yaxis.get_ticklocs(), broken)
    lines = max(name.count("\n") + 1 for name in broken)
    free = _BETWEEN if lines > 1 else 0.0
    return float(
        max(0.0, len(broken) * (lines + free) * _LINE * size / _POINTS_PER_INCH - _OF_PART * height * _share(axes)[1])
    )


def _names(axis: Axis) -> list[str]:
    """Return the texts of the ticks of an axis if they are names; nothing if they are numbers."""
    if not axis.get_visible() or not axis.axes.axison:
        return []
    texts = [tick.get_text() for tick in axis.get_ticklabels()]
    return texts if any(letter.isalpha() for text in texts for letter in text) else []


def _break(texts: Iterable[tuple[Text, float]]) -> None:
    """Break texts that are longer than the inches that each may have."""
    for text, inches in texts:
        text.set_text(_broken(text.get_text(), inches, float(text.get_fontsize())))


def _headings(figure: Figure) -> Iterator[tuple[Text, float]]:
    """Yield headings and notes of a picture and its parts, and the inches that each may have."""
    width = figure.get_size_inches()[0]
    parts: list[FigureBase] = [figure, *figure.subfigs]
    for part in parts:
        for text in (part._suptitle, part._supxlabel):  # type: ignore[attr-defined]
            if text is not None:
                yield text, 0.95 * width


def _labels(figure: Figure) -> Iterator[tuple[Text, float]]:
    """Yield headings and labels of axes, and the inches that each may have."""
    width, height = figure.get_size_inches()
    for axes in figure.axes:
        across, down = _share(axes)
        # Both are in the middle of the axis, which is not that of the picture if there are names beside it.
        names = _NAMES if _names(axes.yaxis) else 0
        inches = 0.9 * max(across - names, 0.4 * across) * width
        yield axes.title, inches
        yield axes.xaxis.label, inches
        yield axes.yaxis.label, _OF_PART * down * height


def _is_last(axes: Axes) -> bool:
    """Return whether nothing is below an axis."""
    place = axes.get_subplotspec()
    return place is not None and place.rowspan.stop == place.get_gridspec().nrows


def _share(axes: Axes) -> tuple[float, float]:
    """Return the share of the picture, across and down, that belongs to an axis."""
    place, figure = axes.get_subplotspec(), axes.get_figure(root=True)
    if place is None or figure is None:
        return 1.0, 1.0
    grid = place.get_gridspec()
    widths: Any = grid.get_width_ratios()
    heights: Any = grid.get_height_ratios()
    across = sum(widths[each] for each in place.colspan) / sum(widths)
    return float(across), float(sum(heights[each] for each in place.rowspan) / sum(heights))
