"""The base of all reports of one picture: runs → frames → picture and text → files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from itertools import count, takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self
from urllib.parse import quote

import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.report.fitting import fit
from rl_design_space.report.latex import latex_table
from rl_design_space.report.look import LATEX, PDF, Look
from rl_design_space.report.markdown import Table, table
from rl_design_space.report.runs import Runs
from rl_design_space.report.spreadsheet import without_formulas
from rl_design_space.report.style import DOTS_PER_INCH, PRINTED, add_mark, number, save
from rl_design_space.report.together import together
from rl_design_space.report.words import Words
from rl_design_space.report.written import MainNumbers, Written

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader

#: Numbers of a report, by what the name of their CSV file adds to that of the report: nothing, `_parts`.
Frames = Mapping[str, pd.DataFrame]
#: Of the frame that every report has.
MAIN = ""
Text = Annotated[str, Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Report(Look, ABC):
    """A picture of runs, with its numbers and a text.

    Picture and text are made of the frames alone: what they show can be checked without drawing. How they look, see
    `Look`, is the same in all reports.

    Attributes:
        title: heading of the report and its picture.
        shows: description of the picture for those who cannot see it.
        notes: paragraphs at the end of the text, in Markdown.
    """

    title: str
    shows: str = ""
    notes: Annotated[tuple[Text, ...], Field(strict=False)] = ()

    @property
    def heading(self) -> str:
        """The title, or one made of the other fields where it may be empty."""
        return self.title

    def heading_of(self, frames: Frames) -> str:
        """Return the heading of what is shown; files are named after `heading`, whatever that is."""
        return self.heading

    @abstractmethod
    def frames(self, runs: Runs) -> Frames:
        """Return the numbers that picture and text show, the main frame under `MAIN`.

        Raises:
            ConfigError: the runs do not have what the report needs.
        """

    @abstractmethod
    def draw(self, frames: Frames) -> Figure:
        """Return the picture."""

    @abstractmethod
    def text(self, frames: Frames) -> list[str]:
        """Return the paragraphs of the text."""

    def numbers(self, frames: Frames) -> list[str]:
        """Return the main numbers as sentences for a terminal; empty if they are the first table."""
        return []

    def main_numbers(self, frames: Frames) -> MainNumbers:
        """Return what the report has found, with labels: the sentences of `numbers`, or else its first table."""
        heading = self._in_words(self.heading_of(frames))
        if lines := self.numbers(frames):
            return MainNumbers.of(heading, map(self.words, lines))
        tables = self.tables(frames)
        return MainNumbers.of(heading, frame=self.table_words.frame(tables[0]) if tables else None)

    def more_pictures(self, frames: Frames) -> Iterable[tuple[str, str, Figure]]:
        """Yield more pictures: what the name of the file adds to that of the report, a description, and the picture."""
        return ()

    def csv(self, frames: Frames) -> Frames:
        """Return the frames as they are written to CSV files; all of them unless a report says otherwise."""
        return frames

    def write(self, study: Study, reader: Reader, folder: Path) -> Written:
        """Write PNG, SVG, CSV and Markdown files called after a study into a folder.

        Args:
            study: the study whose points the report shows.
            reader: of the tracked runs; points without a run are missing, and shown as such.
            folder: made if it does not exist.

        Returns:
            The paths written, with the main numbers.

        Raises:
            ConfigError: the runs do not have what the report needs.
        """
        return self.write_runs(Runs.of_study(study, reader), folder / study.name)

    def write_runs(self, runs: Runs, stem: Path) -> Written:
        """Write the files of any runs, see `write`.

        Args:
            runs: what the report shows.
            stem: path of the files without their suffix.
        """
        with together(stem.parent) as new:
            return self.write_new(runs, stem, new)

    def write_new(self, runs: Runs, stem: Path, new: Path) -> Written:
        """Write the files of any runs into a folder from which they are moved into place.

        Args:
            runs: what the report shows.
            stem: path of the files without their suffix, once they are in place.
            new: folder of the files meanwhile.

        Returns:
            The paths once they are in place, with the main numbers.
        """
        runs = runs if "order" in self.own else runs.ordered(self.order)
        frames = self.frames(runs)
        place, stem = stem.parent, new / stem.name
        paths = self._save(self.draw(frames), self.heading_of(frames), stem, runs.mark)
        for name, frame in self.csv(frames).items():
            paths.append(stem.with_name(f"{stem.name}{name}.csv"))
            without_formulas(frame).to_csv(paths[-1], index=False)
        paths.append(stem.with_name(f"{stem.name}.md"))
        heading = self._in_words(self.heading_of(frames))
        names, pictures = [stem.name], [_picture(self.shows or heading, stem.name)]
        for name, shows, figure in self.more_pictures(frames):
            names.append(f"{stem.name}{name}")
            pictures.append(_picture(shows, names[-1]))
            paths[-1:-1] = self._save(figure, self.heading_of(frames), new / names[-1], runs.mark)
        first, *more = pictures
        text = [_labelled(part, self.words) for part in self.text(frames)]
        if LATEX in self.format:
            paths[-1:-1] = _write_tables(self.tables(frames), self.table_words, stem, [heading, runs.made_by])
        parts = [f"# {heading}", first, runs.made_by, *runs.remarks, *text, *more, *self.notes]
        paths[-1].write_text("\n\n".join(parts) + "\n", encoding="utf-8")
        left = _left(place, names, self.format)
        return Written((place / path.name for path in paths), [self.main_numbers(frames)], left)

    def tables(self, frames: Frames) -> list[pd.DataFrame]:
        """Return the tables for LaTeX and the terminal, as texts: those of the text; else the main frame."""
        found = [part.frame for part in self.text(frames) if isinstance(part, Table)]
        if found or MAIN not in frames:
            return found
        return [frames[MAIN].map(lambda cell: number(cell) if isinstance(cell, float) else str(cell))]

    def looking(self, look: Mapping[str, Any]) -> Self:
        """Return the report with other values of the fields of `Look`; labels and orders are added.

        Raises:
            ConfigError: a value is not allowed.
        """
        if not look:
            return self
        for name in self.own:
            if name in look:
                kind = type(self).__name__
                raise ConfigError.at(
                    name, look[name], f"means something else for {kind}; change it in the study's file"
                )
        both = {name: {**getattr(self, name), **look[name]} for name in ("labels", "order") if name in look}
        values = {field.name: getattr(self, field.name) for field in fields(self) if field.init}
        return construct(type(self), {**values, **look, **both})

    def _in_words(self, heading: str) -> str:
        return self.title or self.words.heading(heading)

    def _save(self, figure: Figure, heading: str, stem: Path, mark: str) -> list[Path]:
        self.words.write_into(figure, {self.title: self.title, heading: self._in_words(heading)})
        add_mark(figure, mark)
        fit(figure, self.width, self.height, self.font_size)
        dots = PRINTED if self.width or self.height else DOTS_PER_INCH
        return save(figure, stem, dots, pdf=PDF in self.format)


def _labelled(part: str, words: Words) -> str:
    if not words:
        return part
    return table(words.frame(part.frame)) if isinstance(part, Table) else words.paragraph(part)


def _write_tables(frames: Sequence[pd.DataFrame], words: Words, stem: Path, made_by: Sequence[str]) -> list[Path]:
    """Write a file for each table; the first has the name of the report."""
    paths = []
    for place, frame in enumerate(frames, 1):
        paths.append(stem.with_name(_table_name(stem.name, place)))
        comment = [*made_by, "Needs the package booktabs."]
        paths[-1].write_text(latex_table(words.frame(frame), comment), encoding="utf-8")
    return paths


def _table_name(name: str, place: int) -> str:
    return f"{name}{f'_{place}' if place > 1 else ''}.tex"


def _left(folder: Path, pictures: Sequence[str], formats: Sequence[str]) -> list[Path]:
    """Return the files that an earlier report has left, in formats that this one is not written in.

    Args:
        folder: of the files.
        pictures: names of the pictures of the report without their suffix; the first is that of the report.
        formats: that it is written in.
    """
    left = [] if PDF in formats else [path for name in pictures if (path := folder / f"{name}.pdf").exists()]
    if LATEX not in formats:
        tables = (folder / _table_name(pictures[0], place) for place in count(1))
        # A report of its own has a text.
        of_this = takewhile(lambda path: path.exists(), tables)
        left += [path for path in of_this if path.stem == pictures[0] or not path.with_suffix(".md").exists()]
    return left


def _picture(shows: str, name: str) -> str:
    return f"![{shows}]({quote(name)}.png)"
