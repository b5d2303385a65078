"""Markdown: tables of frames."""

from __future__ import annotations

import re
from typing import Any

import pandas as pd

from rl_design_space._markdown import escaped

#: A cell of a column that is aligned on the right.
_NUMBER = re.compile(r"[-−]?[\d.,]+ ?%?")


def table(frame: pd.DataFrame) -> str:
    """Return a frame as a Markdown table; columns of numbers are aligned on the right, the index is left out."""
    texts = frame.map(_cell)
    alignments = [_alignment(list(column)) for _, column in texts.items()]
    return texts.rename(columns=_cell).to_markdown(
        index=False, disable_numparse=True, colalign=alignments if len(texts) else None
    )


def _cell(value: Any) -> str:
    return escaped(str(value))


def _alignment(cells: list[str]) -> str:
    filled = [text for text in cells if text]
    return "right" if filled and all(_NUMBER.fullmatch(text) for text in filled) else "left"
