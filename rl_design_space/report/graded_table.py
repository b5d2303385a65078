"""A table of measured numbers and their grades beside published grades, as a heatmap and as Markdown."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.definitions import REGISTERED, Found, defined, definitions_text, registered
from rl_design_space.report.graded_picture import draw_table
from rl_design_space.report.grading import Grading, built
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs

#: Name of the frame of other definitions; its rows are written into the one CSV file.
DEFINITIONS = "definitions"
_MISSING = "missing"


class Measured(NamedTuple):
    """A measured number, its text in one or two lines, and its 95 % interval if there is one."""

    number: float
    text: str
    low: float = np.nan
    high: float = np.nan


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GradedTable(Report):
    """Rows by columns, each cell with a grade, the number behind it and the published grade.

    Attributes:
        gradings: of the columns that are measured, by name.
        definitions: other definitions of a column, each a grading by its name; they stand beside those of the table.
        paper: published grades by row and column, if there are any; columns without a grading are not measured.
        labels: how names read; as they are if left out.
        source: what the published grades are called in picture and text.
        unmeasured: text of cells that are not measured.
    """

    gradings: dict[str, dict[str, Any]]
    definitions: dict[str, dict[str, dict[str, Any]]] = Field(default_factory=dict)
    paper: dict[str, dict[str, str]] = Field(default_factory=dict)
    labels: dict[str, str] = Field(default_factory=dict)
    source: str = "published"
    unmeasured: str = "not measured"

    names_cells: ClassVar[bool] = True

    @property
    @abstractmethod
    def quantities(self) -> tuple[str, ...]:
        """Names of what is measured of each row."""

    @abstractmethod
    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        """Return what is known of each row, by quantity; nothing if its runs are missing."""

    @abstractmethod
    def found(self, runs: Runs) -> Mapping[str, Found]:
        """Return the quantities of the other definitions by what they are measured under, row and quantity."""

    def check_quantity(self, name: str, key: str) -> None:
        """Refuse a quantity of another definition that is not measured.

        Raises:
            ConfigError: there is no such quantity.
        """
        if name not in self.quantities:
            raise ConfigError.unknown("quantity", name, self.quantities, f"{key}.of=")

    def built_gradings(self) -> dict[str, Grading]:
        """Return the gradings by column, each with its quantity.

        Raises:
            ConfigError: a grading has a value that is not allowed.
        """
        gradings = {}
        for place, (column, node) in enumerate(self.gradings.items()):
            key = f"study.report.gradings.{column}"
            named = {"of": self.quantities[place], **node} if place < len(self.quantities) else node
            gradings[column] = built(named, key)
            if gradings[column].of not in self.quantities:
                raise ConfigError.unknown("quantity", gradings[column].of, self.quantities, f"{key}.of=")
        return gradings

    def defined_quantities(self) -> set[str]:
        """Return the quantities of the other definitions."""
        gradings = self._every_grading().values()
        return {grading.of for by_name in gradings for name, grading in by_name.items() if name != REGISTERED}

    def _every_grading(self) -> dict[str, dict[str, Grading]]:
        """Return the gradings by column and name of the definition, those of the table itself first.

        Raises:
            ConfigError: a definition has a value that is not allowed.
        """
        gradings = {column: {REGISTERED: grading} for column, grading in self.built_gradings().items()}
        for column, by_name in self.definitions.items():
            for name, node in by_name.items():
                key = f"study.report.definitions.{column}.{name}"
                grading = built(node, key)
                self.check_quantity(grading.of, key)
                gradings.setdefault(column, {})[name] = grading
        return gradings

    def frames(self, runs: Runs) -> Frames:
        """Return the cells of the table, and those by other definitions.

        The main frame has row, column, number, grade, paper, measured (text in one or two lines), low and high; the
        other one is that of `report.definitions.defined`, the definitions of the table itself first.
        """
        every = self._every_grading()
        main = self.graded(self.measured(runs))
        others = registered(main, self.built_gradings())
        if self.definitions:
            rows = list(dict.fromkeys(main["row"]))
            others = pd.concat([others, defined(every, self.found(runs), rows, self.paper)])
        return {MAIN: main, DEFINITIONS: others}

    def graded(self, measured: Mapping[str, Mapping[str, Measured]]) -> pd.DataFrame:
        """Return the cells of the table, column by column, see `frames`."""
        gradings = self.built_gradings()
        cells = []
        columns = [*(name for grades in self.paper.values() for name in grades), *gradings]
        for column in dict.fromkeys(columns):
            grading = gradings.get(column)
            found = {row: each[grading.of] for row, each in measured.items() if grading and each}
            least = min((each.number for each in found.values()), default=np.nan)
            for row in measured:
                number, text, low, high = found.get(row, Measured(np.nan, _MISSING if grading else self.unmeasured))
                grade = grading.grade(number, least) if grading and row in found else ""
                published = self.paper.get(row, {}).get(column, "")
                cells.append((row, column, number, grade, published, text, low, high))
        return pd.DataFrame(cells, columns=["row", "column", "number", "grade", "paper", "measured", "low", "high"])

    def csv(self, frames: Frames) -> Frames:
        """Return one frame: the cells of the table, then those by other definitions."""
        main, others = frames[MAIN], frames.get(DEFINITIONS, pd.DataFrame())
        main = main.assign(definition=REGISTERED, under="", order="")
        if not others.empty:
            of_table = (others["definition"] == REGISTERED) & (others["under"] == "")
            orders = others[of_table].drop_duplicates("column").set_index("column")["order"]
            main = main.assign(order=main["column"].map(orders).fillna(""))
            others = others[~of_table]
        cells = pd.concat([main, others])
        names = ["row", "column", "number", "grade", "paper", "measured", "definition", "under", "low", "high", "order"]
        return {MAIN: cells.assign(measured=cells["measured"].map(_in_one_line))[names]}

    def draw(self, frames: Frames) -> Figure:
        return draw_table(frames[MAIN], frames.get(DEFINITIONS), self.title, self.labels, self.source)

    def text(self, frames: Frames) -> list[str]:
        """Return the cells, the rules of their grades, how they were measured, and the same by other definitions."""
        cells = frames[MAIN]
        texts = [_cell_text(cell, self.source) for cell in cells.to_dict("records")]
        shown = cells.assign(text=texts).pivot_table(
            index="row", columns="column", values="text", aggfunc="first", sort=False
        )
        shown = shown.rename(index=self.labels, columns=self.labels).rename_axis(index="", columns=None)
        gradings = self.built_gradings()
        rules = [
            f"- **{self.labels.get(column, column)}**: {grading.means}. {grading.rule()}."
            for column, grading in gradings.items()
        ]
        others: list[str] = []
        if self.definitions and DEFINITIONS in frames:
            others = definitions_text(frames[DEFINITIONS], self._every_grading(), self.labels, self.source)
        return [table(shown.reset_index()), "\n".join(rules), *self.how(), *others]

    def how(self) -> list[str]:
        """Return paragraphs on how the cells were measured."""
        return []


def _cell_text(cell: Mapping[Any, Any], source: str) -> str:
    grade = f"**{cell['grade']}** " if cell["grade"] else ""
    published = f"; {source} {cell['paper']}" if cell["paper"] else ""
    return f"{grade}{_in_one_line(cell['measured'])}{published}"


def _in_one_line(text: str) -> str:
    return " ".join(text.split())
