"""Markdown: tables of frames."""

from __future__ import annotations

import re
from typing import Any, Literal

import pandas as pd

from rl_design_space._markdown import escaped

#: A cell of a column that is aligned on the right.
_NUMBER = re.compile(r"[-−]?[\d.,]+ ?%?")
#: Code and bold text in a cell.
MARKED = re.compile(r"(`+)(.+?)\1|\*\*(.+?)\*\*")


class Table(str):
    """A Markdown table, with the frame that it was made of: the same table in another format is made of that."""

    frame: pd.DataFrame


def table(frame: pd.DataFrame) -> Table:
    """Return a frame as a Markdown table; columns of numbers are aligned on the right, the index is left out."""
    texts = frame.map(_cell)
    alignments = [alignment(list(column)) for _, column in texts.items()]
    made = Table(
        texts.rename(columns=_cell).to_markdown(
            index=False, disable_numparse=True, colalign=alignments if len(texts) else None
        )
    )
    made.frame = frame
    return made


def _cell(value: Any) -> str:
    return escaped(str(value))


def unmarked(cell: str) -> str:
    """Return a cell as it is shown where there is neither code nor bold text."""
    return MARKED.sub(lambda found: found[2].strip() if found[2] else found[3], cell)


def alignment(cells: list[str]) -> Literal["left", "right"]:
    """Return on which side the cells of a column are aligned."""
    filled = [text for text in cells if text]
    return "right" if filled and all(_NUMBER.fullmatch(text) for text in filled) else "left"
