"""Numbers of which some are bounds, as a column of a frame and as text: `≥ 100`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import pandas as pd

from rl_design_space.report.style import interval, number

#: Column that says which numbers of a row are bounds, and which way: `value ≥, high ≥`, see `Bounded`.
BOUNDS = "bounds"
#: What a bound is, for texts.
NOTE = "≥ and ≤: a bound, because the curve, or a resampled one, does not get there within the trials."


def without_exact(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a frame without its column of bounds if all of its numbers are exact."""
    return frame.drop(columns=BOUNDS) if (frame[BOUNDS] == "").all() else frame


def notes(frame: pd.DataFrame) -> list[str]:
    """Return what bounds are, if there are any."""
    return [NOTE] if BOUNDS in frame else []


def is_bound(row: Mapping[Any, Any], name: str = "value") -> bool:
    """Return whether a number of a row is a bound."""
    return name in _signs(row)


def shown(row: Mapping[Any, Any], name: str = "value") -> str:
    """Return a number of a row as text."""
    if math.isnan(row[name]):
        return "–"
    return f"{_signs(row).get(name, '')} {number(row[name])}".strip()


def shown_interval(row: Mapping[Any, Any]) -> str:
    """Return the interval of a row as text; empty if it has none."""
    if not {"low", "high"} & _signs(row).keys():
        return interval(row["low"], row["high"])
    ends = [shown(row, "low"), shown(row, "high")]
    return ends[0] if ends[0] == ends[1] else " – ".join(ends)


def _signs(row: Mapping[Any, Any]) -> dict[str, str]:
    """Return the signs of the numbers that are bounds, by their name."""
    return dict(part.split(" ") for part in str(row.get(BOUNDS, "")).split(", ") if part)
