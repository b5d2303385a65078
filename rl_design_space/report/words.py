"""Labels in what a report shows: its picture, its text and its tables. Files of numbers keep the names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import Any

import pandas as pd
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text

from rl_design_space.report.parameters import text as plain

#: A span of code in Markdown: a command keeps its names.
_CODE = re.compile(r"(`+[^`]*`+)")
#: What separates names that stand for themselves: in a list, in an interaction, in the lines of a tick.
_SEPARATOR = re.compile(r"(, | × |\n)")
#: Several values of parameters, as on the command line.
_VALUES = re.compile(r"[\w.]+=[^\s,;)]+(?: [\w.]+=[^\s,;)]+)+")
#: What no English word has in it.
_SIGNS = re.compile(r"[=._/]")


class Words:
    """How names and values read.

    A label belongs to a parameter (`exploration.k`), to a value of it (`representation=ad_hoc`) or to a measure
    (`total_steps`). The label of a value stands for name and value. Names that are English words, such as `reward`,
    are replaced where they stand alone, not within a sentence.

    Args:
        labels: texts by name.
    """

    def __init__(self, labels: Mapping[str, str]) -> None:
        self.labels = dict(labels)

    def __bool__(self) -> bool:
        return bool(self.labels)

    def name(self, name: str, without_label: str = "") -> str:
        """Return how the name of a parameter, measure or scale reads: its label, or else this text, or the name."""
        return self.labels.get(name, without_label or name)

    def value(self, name: str, value: Any) -> str:
        """Return how a value of a parameter reads beside its name."""
        return self.labels.get(f"{name}={plain(value)}", plain(value))

    def __call__(self, text: str) -> str:
        """Return a text with the labels of the names in it."""
        if not self.labels or not text:
            return text
        found, begin = "", 0
        for values in _VALUES.finditer(text):
            found += self._within(text[begin : values.start()]) + self._listed(values[0])
            begin = values.end()
        parts = _SEPARATOR.split(found + self._within(text[begin:]))
        return "".join(self._alone.get(part, part) if place % 2 == 0 else part for place, part in enumerate(parts))

    def heading(self, text: str) -> str:
        """Return a heading made of names, in which they are labelled wherever they stand."""
        if not self.labels:
            return text
        return self._every.sub(lambda match: self.labels[match[0]], text)

    def paragraph(self, text: str) -> str:
        """Return a paragraph of Markdown, its code as it is."""
        parts = _CODE.split(text) if self.labels else [text]
        return "".join(part if place % 2 else self(part) for place, part in enumerate(parts))

    def frame(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return a table of texts with labels in its header and its cells."""
        if not self.labels:
            return frame
        return frame.map(lambda cell: self(cell) if isinstance(cell, str) else cell).rename(
            columns=lambda column: self(str(column))
        )

    def write_into(self, figure: Figure, headings: Mapping[str, str]) -> None:
        """Write the labels into a picture.

        Args:
            figure: the picture.
            headings: beginnings of texts that are replaced as a whole, by what was drawn.
        """
        if not self.labels:
            return
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                _relabel(axis, self)
        for artist in figure.findobj(Text):
            assert isinstance(artist, Text)
            drawn = artist.get_text()
            heading = next((each for each in headings if each and drawn.startswith(each)), None)
            if heading is not None:
                artist.set_text(f"{headings[heading]}{drawn.removeprefix(heading)}")
            else:
                artist.set_text(self(drawn))

    def _listed(self, text: str) -> str:
        """Return values of parameters, with commas between them if one has a label."""
        values = text.split(" ")
        labelled = list(map(self._within, values))
        return text if labelled == values else ", ".join(labelled)

    def _within(self, text: str) -> str:
        return self._anywhere.sub(lambda match: self.labels[match[0]], text)

    @cached_property
    def _anywhere(self) -> re.Pattern[str]:
        """What is replaced within sentences, too: all but English words that no value follows."""
        return _pattern(f"{re.escape(name)}{'' if _SIGNS.search(name) else '(?==)'}" for name in _ordered(self.labels))

    @cached_property
    def _every(self) -> re.Pattern[str]:
        return _pattern(map(re.escape, _ordered(self.labels)))

    @cached_property
    def _alone(self) -> dict[str, str]:
        return {name: text for name, text in self.labels.items() if not _SIGNS.search(name)}


def _ordered(names: Iterable[str]) -> list[str]:
    """Return names, those first that begin with others."""
    return sorted(names, key=len, reverse=True)


def _pattern(names: Iterable[str]) -> re.Pattern[str]:
    """Return a pattern that matches whole names."""
    return re.compile(rf"(?<![\w.=/])(?:{'|'.join(names)})(?![\w/]|[.,]\w)")


def _relabel(axis: Axis, words: Callable[[str], str]) -> None:
    """Write labels into ticks that have names; those with numbers alone stay as they are."""
    for is_minor in (False, True):
        texts = [tick.get_text() for tick in axis.get_ticklabels(minor=is_minor)]
        labelled = list(map(words, texts))
        if labelled != texts:
            axis.set_ticks(axis.get_ticklocs(minor=is_minor), labelled, minor=is_minor)
