"""The base of all reports of one picture: runs → frames → picture and text → files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import quote

import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.report.runs import Runs
from rl_design_space.report.spreadsheet import without_formulas
from rl_design_space.report.style import save

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

#: Numbers of a report, by what the name of their CSV file adds to that of the report: nothing, `_parts`.
Frames = Mapping[str, pd.DataFrame]
#: Of the frame that every report has.
MAIN = ""
Text = Annotated[str, Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Report(ABC):
    """A picture of runs, with its numbers and a text.

    Picture and text are made of the frames alone: what they show can be checked without drawing.

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
        """Return the main numbers as lines for a terminal; empty if the text begins with them."""
        return []

    def more_pictures(self, frames: Frames) -> Iterable[tuple[str, str, Figure]]:
        """Yield more pictures: what the name of the file adds to that of the report, a description, and the picture."""
        return ()

    def csv(self, frames: Frames) -> Frames:
        """Return the frames as they are written to CSV files; all of them unless a report says otherwise."""
        return frames

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write PNG, SVG, CSV and Markdown files called after a study into a folder.

        Args:
            study: the study whose points the report shows.
            reader: of the tracked runs; points without a run are missing, and shown as such.
            folder: made if it does not exist.

        Returns:
            The paths written.

        Raises:
            ConfigError: the runs do not have what the report needs.
        """
        return self.write_runs(Runs.of_study(study, reader), folder / study.name)

    def write_runs(self, runs: Runs, stem: Path) -> list[Path]:
        """Write the files of any runs, see `write`.

        Args:
            runs: what the report shows.
            stem: path of the files without their suffix.
        """
        frames = self.frames(runs)
        stem.parent.mkdir(parents=True, exist_ok=True)
        paths = save(self.draw(frames), stem, runs.mark)
        for name, frame in self.csv(frames).items():
            paths.append(stem.with_name(f"{stem.name}{name}.csv"))
            without_formulas(frame).to_csv(paths[-1], index=False)
        paths.append(stem.with_name(f"{stem.name}.md"))
        pictures = [_picture(self.shows or self.heading, stem.name)]
        for name, shows, figure in self.more_pictures(frames):
            pictures.append(_picture(shows, f"{stem.name}{name}"))
            paths[-1:-1] = save(figure, stem.with_name(f"{stem.name}{name}"), runs.mark)
        first, *more = pictures
        parts = [f"# {self.heading}", first, runs.made_by, *runs.remarks, *self.text(frames), *more, *self.notes]
        paths[-1].write_text("\n\n".join(parts) + "\n", encoding="utf-8")
        runs.tell(self.numbers(frames))
        return paths


def _picture(shows: str, name: str) -> str:
    return f"![{shows}]({quote(name)}.png)"
