"""CSV files that a spreadsheet may open: text from a store is no formula in them, see decision 0020."""

from __future__ import annotations

import re
from typing import Any

import pandas as pd

#: How text begins that spreadsheets take for a formula; numbers and intervals begin with signs, too.
_FORMULA = re.compile(r"\s*[=@\t\r]|\s*[-+](?![\d.,\s–+-]*(e[-+]?\d+)?$|[\d.,]+ – )", re.IGNORECASE)


def without_formulas(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a frame with an apostrophe before names and text that a spreadsheet would compute."""
    guarded = frame.copy()
    for name in frame:
        if not pd.api.types.is_numeric_dtype(frame[name]):
            guarded[name] = frame[name].map(_plain)
    return guarded.rename(columns=_plain)


def _plain(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and _FORMULA.match(value) else value
