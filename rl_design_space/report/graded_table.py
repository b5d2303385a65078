"""A table of measured numbers and their grades beside published grades, as a heatmap and as Markdown."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.cells import Line, hatch, write
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import FRAME, styled

#: From much to nothing; a number that keeps no limit gets the last one.
GRADES = ("++", "+", "0", "−")
#: Much is dark; even in lightness, so that it can be read in grey.
_COLOURS = ["#123a6b", "#5b86b8", "#b9cfe4", "#f2f2ee"]
_MISSING = "missing"


class Measured(NamedTuple):
    """A measured number, and its text in one or two lines."""

    number: float
    text: str


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Grading:
    """How a column is graded.

    Attributes:
        means: what the number is.
        limits: for ++, + and 0; a number gets the first grade whose limit it keeps.
        larger: whether a limit is kept by a number that is at least as large, rather than at most.
        of_least: whether limits are in multiples of the column's least number.
        of: the quantity that is graded; without it, columns are graded in the order of the report's quantities.
    """

    means: Annotated[str, Field(min_length=1)]
    limits: Annotated[tuple[float, float, float], Field(strict=False)]
    larger: bool = False
    of_least: bool = False
    of: str = ""

    def grade(self, number: float, least: float = 1.0) -> str:
        """Return the grade of a number in a column whose least number is `least`."""
        measured = number / least if self.of_least and least else number
        for grade, limit in zip(GRADES, self.limits, strict=False):
            if (measured >= limit) if self.larger else (measured <= limit):
                return grade
        return GRADES[-1]

    def rule(self) -> str:
        """Return the limits in words."""
        sign = "≥" if self.larger else "≤"
        unit = " × the least" if self.of_least else ""
        limits = ", ".join(f"{grade} {sign} {limit:g}{unit}" for grade, limit in zip(GRADES, self.limits, strict=False))
        return f"{limits}, otherwise {GRADES[-1]}"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GradedTable(Report):
    """Rows by columns, each cell with a grade, the number behind it and the published grade.

    Attributes:
        gradings: of the columns that are measured, by name.
        paper: published grades by row and column, if there are any; columns without a grading are not measured.
        labels: how names read; as they are if left out.
        source: what the published grades are called in picture and text.
        unmeasured: text of cells that are not measured.
    """

    gradings: dict[str, dict[str, Any]]
    paper: dict[str, dict[str, str]] = Field(default_factory=dict)
    labels: dict[str, str] = Field(default_factory=dict)
    source: str = "published"
    unmeasured: str = "not measured"

    @property
    @abstractmethod
    def quantities(self) -> tuple[str, ...]:
        """Names of what is measured of each row."""

    @abstractmethod
    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        """Return what is known of each row, by quantity; nothing if its runs are missing."""

    def built_gradings(self) -> dict[str, Grading]:
        """Return the gradings by column, each with its quantity.

        Raises:
            ConfigError: a grading has a value that is not allowed.
        """
        gradings = {}
        for place, (column, node) in enumerate(self.gradings.items()):
            key = f"study.report.gradings.{column}"
            named = {"of": self.quantities[place], **node} if place < len(self.quantities) else node
            gradings[column] = construct(Grading, named, key)
            if gradings[column].of not in self.quantities:
                raise ConfigError.unknown("quantity", gradings[column].of, self.quantities, f"{key}.of=")
        return gradings

    def frames(self, runs: Runs) -> Frames:
        """Return row, column, number, grade, paper and measured (text in one or two lines): one row for each cell."""
        return {MAIN: self.graded(self.measured(runs))}

    def graded(self, measured: Mapping[str, Mapping[str, Measured]]) -> pd.DataFrame:
        """Return the cells of the table, column by column, see `frames`."""
        gradings = self.built_gradings()
        cells = []
        for column in _distinct([*(name for grades in self.paper.values() for name in grades), *gradings]):
            grading = gradings.get(column)
            found = {row: each[grading.of] for row, each in measured.items() if grading and each}
            least = min((each.number for each in found.values()), default=np.nan)
            for row in measured:
                number, text = found.get(row, Measured(np.nan, _MISSING if grading else self.unmeasured))
                grade = grading.grade(number, least) if grading and row in found else ""
                published = self.paper.get(row, {}).get(column, "")
                cells.append((row, column, number, grade, published, text))
        return pd.DataFrame(cells, columns=["row", "column", "number", "grade", "paper", "measured"])

    def csv(self, frames: Frames) -> Frames:
        cells = frames[MAIN]
        return {MAIN: cells.assign(measured=cells["measured"].map(_in_one_line))}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.title, self.labels, self.source)

    def text(self, frames: Frames) -> list[str]:
        """Return the cells, and the rules of their grades."""
        cells = frames[MAIN]
        texts = [_cell_text(cell, self.source) for cell in cells.to_dict("records")]
        shown = cells.assign(text=texts).pivot_table(
            index="row", columns="column", values="text", aggfunc="first", sort=False
        )
        shown = shown.rename(index=self.labels, columns=self.labels).rename_axis(index="", columns=None)
        rules = [
            f"- **{self.labels.get(column, column)}**: {grading.means}. {grading.rule()}."
            for column, grading in self.built_gradings().items()
        ]
        return [table(shown.reset_index()), "\n".join(rules)]


def _cell_text(cell: Mapping[Any, Any], source: str) -> str:
    grade = f"**{cell['grade']}** " if cell["grade"] else ""
    published = f"; {source} {cell['paper']}" if cell["paper"] else ""
    return f"{grade}{_in_one_line(cell['measured'])}{published}"


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


def _distinct(values: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(values))


@styled()
def _draw(cells: pd.DataFrame, title: str, labels: Mapping[str, str], source: str) -> Figure:
    """Draw rows by columns, coloured by grade."""
    rows, columns = _distinct(cells["row"]), _distinct(cells["column"])
    shade = np.full((len(rows), len(columns)), np.nan)
    for cell in cells[cells["grade"] != ""].to_dict("records"):
        shade[rows.index(cell["row"]), columns.index(cell["column"])] = GRADES.index(cell["grade"])
    figure, axis = plt.subplots(figsize=(1.4 + 2.5 * len(columns), 1.5 + 1.25 * len(rows)), layout="constrained")
    sns.heatmap(
        shade, ax=axis, cmap=_COLOURS, vmin=-0.5, vmax=len(GRADES) - 0.5, cbar=False, linewidths=2,
        linecolor="white", xticklabels=[labels.get(c, c) for c in columns],
        yticklabels=[labels.get(r, r) for r in rows],
    )  # fmt: skip
    for cell in cells.to_dict("records"):
        _write_cell(axis, cell, columns.index(cell["column"]), rows.index(cell["row"]), source)
    axis.tick_params(length=0, labelsize=10)
    axis.xaxis.tick_top()
    axis.set_yticklabels(axis.get_yticklabels(), rotation=0)
    figure.suptitle(title, fontsize=12)
    compared = bool((cells["paper"] != "").any())
    framed = f' Framed in orange: the grade differs from the one after "{source}:".' if compared else ""
    figure.supxlabel(
        f"Large: measured grade, from the number below it with its 95 % interval.{framed}\n"
        "Hatched: missing or not measured.",
        fontsize=8,
    )
    return figure


def _write_cell(axis: Axes, cell: dict[Any, Any], x: int, y: int, source: str) -> None:
    grade, text = cell["grade"], cell["measured"]
    published = f"{source}: {cell['paper']}" if cell["paper"] else ""
    if not grade:
        hatch(axis, x, y, f"{text}\n{published}".strip())
        return
    lines: list[Line] = [
        (0.22, grade, {"fontsize": 15, "fontweight": "bold"}),
        (0.56, text, {"fontsize": 8}),
        (0.87, published, {"fontsize": 8, "style": "italic"}),
    ]
    write(axis, x, y, lines, "white" if grade in GRADES[:2] else "black")
    if cell["paper"] and cell["paper"] != grade:
        axis.add_patch(Rectangle((x + 0.03, y + 0.03), 0.94, 0.94, fill=False, edgecolor=FRAME, linewidth=2))
