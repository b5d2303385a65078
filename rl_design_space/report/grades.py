"""Grades: numbers as the paper's ++, +, 0 and −, by limits that a study's file gives."""

from __future__ import annotations

from dataclasses import dataclass as plain_dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

#: From much to nothing; the last is what no limit is reached for.
GRADES = ("++", "+", "0", "−")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Grading:
    """How a column is graded.

    Attributes:
        means: what the number is.
        limits: for ++, + and 0; a number gets the first grade whose limit it keeps.
        larger: whether a limit is kept by a number that is at least as large, rather than at most.
        of_least: whether limits are in multiples of the column's least number.
    """

    means: Annotated[str, Field(min_length=1)]
    limits: Annotated[tuple[float, float, float], Field(strict=False)]
    larger: bool = False
    of_least: bool = False

    def grade(self, number: float, least: float = 1.0) -> str:
        """The grade of a number in a column whose least number is this."""
        measured = number / least if self.of_least and least else number
        for grade, limit in zip(GRADES, self.limits, strict=False):
            if (measured >= limit) if self.larger else (measured <= limit):
                return grade
        return GRADES[-1]

    def rule(self) -> str:
        """The limits in words."""
        sign = "≥" if self.larger else "≤"
        unit = " × the least" if self.of_least else ""
        limits = ", ".join(f"{grade} {sign} {limit:g}{unit}" for grade, limit in zip(GRADES, self.limits, strict=False))
        return f"{limits}, otherwise {GRADES[-1]}"


@plain_dataclass(frozen=True)
class Cell:
    """A cell of a graded table.

    Attributes:
        row, column: where it stands.
        number: measured; NaN if missing or not to be measured.
        text: the number as people read it, in one or two lines.
        grade: ours; empty without a number.
        paper: the paper's.
    """

    row: str
    column: str
    number: float
    text: str
    grade: str
    paper: str


def cells_frame(cells: Sequence[Cell], **more: Any) -> pd.DataFrame:
    """One row a cell."""
    import pandas as pd

    rows = [
        {"row": c.row, "column": c.column, "number": c.number, "grade": c.grade, "paper": c.paper,
         "measured": " ".join(c.text.split())}
        for c in cells
    ]  # fmt: skip
    columns = ["row", "column", "number", "grade", "paper", "measured"]
    return pd.DataFrame(rows, columns=columns).assign(**more)
