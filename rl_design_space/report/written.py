"""What a report returns: the files that it has written, and its main numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class MainNumbers:
    """What a report has found, as texts: sentences, a table, or both.

    Attributes:
        heading: of the report.
        lines: sentences.
        header: of the table.
        rows: of the table, below the sentences; cells may have code and bold text in Markdown.
    """

    heading: str
    lines: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()

    @classmethod
    def of(cls, heading: str, lines: Iterable[str] = (), frame: pd.DataFrame | None = None) -> Self:
        """Return sentences and a table, which is given as a frame."""
        if frame is None:
            return cls(heading, tuple(lines))
        rows = tuple(tuple(map(str, row)) for row in frame.itertuples(index=False, name=None))
        return cls(heading, tuple(lines), tuple(map(str, frame.columns)), rows)


class Written(list[Path]):
    """Paths of files.

    Attributes:
        numbers: of the reports that the files are of.
        left: files of earlier reports of the same names, in formats that were not asked for now.
    """

    def __init__(
        self, paths: Iterable[Path] = (), numbers: Sequence[MainNumbers] = (), left: Sequence[Path] = ()
    ) -> None:
        super().__init__(paths)
        self.numbers, self.left = tuple(numbers), tuple(left)

    @classmethod
    def joined(cls, parts: Iterable[Sequence[Path]]) -> Self:
        """Return the files of several reports; one that returns plain paths has no main numbers."""
        found = list(parts)
        return cls(
            (path for part in found for path in part),
            [each for part in found for each in numbers_of(part)],
            [path for part in found for path in left_of(part)],
        )


def numbers_of(paths: Sequence[Path]) -> tuple[MainNumbers, ...]:
    """Return the main numbers that a report has returned with its paths; none if it has returned plain paths."""
    return paths.numbers if isinstance(paths, Written) else ()


def left_of(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the files that earlier reports have left, see `Written`; none if a report has returned plain paths."""
    return paths.left if isinstance(paths, Written) else ()
