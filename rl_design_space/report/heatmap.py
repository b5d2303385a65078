"""A scalar by two parameters, or by two sets of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._markdown import escaped
from rl_design_space._strict import STRICT
from rl_design_space.config.measure_name import ValueName
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.best_set import BEST_NOTE, IN_SET, STAR, among_best
from rl_design_space.report.bounds import notes, shown, shown_interval, without_exact
from rl_design_space.report.cells import colour_bar, colour_cells, hatch, write
from rl_design_space.report.parameters import check_averaged, label, text
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import number, styled

#: Parameters, on the command line separated by commas.
Names = Annotated[
    tuple[str, ...],
    BeforeValidator(lambda names: tuple(names.split(",")) if isinstance(names, str) else tuple(names)),
    Field(min_length=1),
]
#: Size of a cell in inches, and the longest side of a picture.
_WIDTH, _HEIGHT, _LONGEST = 1.15, 0.62, 40.0


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Heatmap(Report):
    """A table of colours; cells without a run are hatched.

    Attributes:
        rows: parameters whose values make the rows.
        cols: parameters whose values make the columns.
        value: scalar or measure that is shown, see docs/reports.md.
        mean: whether runs of one cell that differ in more than their seed are averaged.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    rows: Names
    cols: Names
    value: ValueName = "total_steps"
    mean: bool = False
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("order", "scale", "colour_map")

    @property
    def heading(self) -> str:
        return self.title or f"{self.value} by {', '.join(self.rows)} and {', '.join(self.cols)}"

    def frames(self, runs: Runs) -> Frames:
        """Return row, column, value, low, high (95 % over periods), bounds, runs: one row for each cell.

        `in_best_set` is added where it is defined: if each cell is one design, and all share periods.
        """
        rows, columns = runs.grouped(self.rows), runs.grouped(self.cols)
        cells, inside = [], []
        for row in rows:
            for column in columns:
                points = [point for point in rows[row] if point.key(self.cols) == column]
                where = f"cell ({label(self.rows, row)}, {label(self.cols, column)})"
                advice = "give them an axis with --rows or --cols"
                check_averaged([point.choices for point in points], where, advice, self.mean)
                estimate = runs.estimate(points, self.value)
                names = dict(zip((*self.rows, *self.cols), (*row, *column), strict=True))
                recorded = sum(point.run is not None for point in points)
                inside.append(points)
                cells.append({**names, **estimate._asdict(), "runs": recorded})
        frame = without_exact(pd.DataFrame(cells))
        best = among_best(inside, runs, self.value)
        return {MAIN: frame if best is None else frame.assign(**{IN_SET: best})}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def tables(self, frames: Frames) -> list[pd.DataFrame]:
        """Return the cells as they are arranged in the picture."""
        cells = frames[MAIN]
        keys = {axis: cells[list(names)].map(text) for axis, names in (("row", self.rows), ("column", self.cols))}
        rows = keys["row"].apply(lambda row: ", ".join(map(self.words.value, self.rows, row)), axis=1)
        columns = keys["column"].apply(lambda row: ", ".join(map(self.words.value, self.cols, row)), axis=1)
        found = pd.DataFrame(
            {"row": rows, "column": columns, "shown": [shown(row) for row in cells.to_dict("records")]}
        )
        placed = found.pivot_table(index="row", columns="column", values="shown", aggfunc="first", sort=False)
        names = [", ".join(map(self.words.name, each)) for each in (self.rows, self.cols)]
        return [placed.rename_axis(index=" / ".join(names), columns=None).reset_index()]

    def numbers(self, frames: Frames) -> list[str]:
        """Return least and largest value."""
        return [f"{which}: {value} with {cell}" for which, value, cell in self._ends(frames)]

    def _ends(self, frames: Frames) -> list[tuple[str, str, str]]:
        """Return least and largest value, with the parameters of their cells; nothing if no cell is known."""
        names = [*self.rows, *self.cols]
        ordered = frames[MAIN].dropna(subset="value").sort_values("value").to_dict("records")
        ends = (("Least", ordered[0]), ("Most", ordered[-1])) if ordered else ()
        return [(which, shown(row), label(names, [row[name] for name in names])) for which, row in ends]

    def text(self, frames: Frames) -> list[str]:
        """Return least and largest value, and how many cells are missing."""
        cells = frames[MAIN]
        known = cells.dropna(subset="value")
        parts = [f"{which}: {value} with {escaped(cell)}." for which, value, cell in self._ends(frames)]
        if missing := len(cells) - len(known):
            parts.append(f"Hatched: {missing} of {len(cells)} cells have no run.")
        star = [BEST_NOTE] if IN_SET in cells else []
        return [*parts, "Small: the 95 % bootstrap interval over periods.", *star, *notes(cells)]


@styled()
def _draw(frame: pd.DataFrame, look: Heatmap) -> Figure:
    def keys(names: Sequence[str], separator: str) -> pd.Series[str]:
        return frame[list(names)].apply(lambda row: separator.join(map(look.words.value, names, row)), axis=1)

    table = frame.assign(row=keys(look.rows, ", "), column=keys(look.cols, "\n"))
    values = table.pivot_table(index="row", columns="column", values="value", dropna=False, sort=False)
    measured = table["value"].dropna()
    low, high = (measured.min(), measured.max()) if len(measured) else (0.0, 1.0)
    norm = LogNorm(low, high) if look.is_log(measured) else Normalize(low, high)
    size = [_WIDTH * max(len(values.columns), 3) + 2.6, _HEIGHT * max(len(values), 3) + 1.6]
    figure, axis = plt.subplots(figsize=[min(side, _LONGEST) for side in size], layout="constrained")
    inks = colour_cells(axis, values, norm, colour_map=look.cells_map)
    places = values.index.tolist(), values.columns.tolist()
    for cell in table.to_dict("records"):
        y, x = (each.index(cell[name]) for each, name in zip(places, ("row", "column"), strict=True))
        if np.isnan(cell["value"]):
            hatch(axis, x, y, "")
            continue
        between = shown_interval(cell)
        star = f" {STAR}" if cell.get(IN_SET) else ""
        main = (0.36 if between else 0.5, f"{shown(cell)}{star}", {"fontsize": 10, "fontweight": "bold"})
        write(axis, x, y, [main, (0.72, between, {"fontsize": 6.5})], inks[y][x])
    axis.set_ylabel(", ".join(look.rows))
    axis.set_xlabel(", ".join(look.cols))
    axis.set_title(look.heading, fontsize=11)
    if low < high:
        ticks = LogLocator(subs=(1, 2, 5)) if isinstance(norm, LogNorm) else None
        bar = colour_bar(figure, [axis], norm, look.cells_map, ticks=ticks, format=lambda value, _: number(value))
        bar.set_label(look.value)
    return figure
