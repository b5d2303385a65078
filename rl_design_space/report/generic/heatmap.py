"""A number by two parameters, or by two sets of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.report.generic.figure import Figure, interval, number

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Drawing

    from rl_design_space.report.generic.selection import Selection

#: Parameters, on the command line separated by commas.
Names = Annotated[
    tuple[str, ...],
    BeforeValidator(lambda names: tuple(names.split(",")) if isinstance(names, str) else tuple(names)),
    Field(min_length=1),
]
#: Size of a cell in inches, and the longest side of a picture.
_WIDTH, _HEIGHT, _LONGEST = 1.15, 0.62, 40.0
#: Times the least value from which on colours are logarithmic.
_DECADE = 10


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Heatmap(Figure):
    """A table of colours; cells without a run are hatched.

    Attributes:
        rows: parameters whose values make the rows.
        cols: parameters whose values make the columns.
        value: scalar that is shown, see `LearningCurves.scalars`.
        mean: whether runs of one cell that differ in more than their seed are averaged.
        title: made of the others if empty.
    """

    rows: Names
    cols: Names
    value: str = "total_steps"
    mean: bool = False
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value} by {', '.join(self.rows)} and {', '.join(self.cols)}"

    def frame(self, selection: Selection) -> pd.DataFrame:
        """Row, column, value, low, high (95 % over periods), runs: a row a cell."""
        import pandas as pd

        from rl_design_space.report.generic.selection import check_averaged, label

        rows, columns = selection.grouped(self.rows), selection.grouped(self.cols)
        cells = []
        for row in rows:
            for column in columns:
                points = [point for point in rows[row] if point.key(self.cols) == column]
                where = f"cell ({label(self.rows, row)}, {label(self.cols, column)})"
                check_averaged(points, where, "give them an axis with --rows or --cols", self.mean)
                estimate = selection.estimate(points, self.value)
                names = dict(zip((*self.rows, *self.cols), (*row, *column), strict=True))
                runs = sum(point.run is not None for point in points)
                cells.append({**names, **estimate._asdict(), "runs": runs})
        return pd.DataFrame(cells)

    def draw(self, frame: pd.DataFrame) -> Drawing:
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt
        from matplotlib.colors import LogNorm, Normalize
        from matplotlib.ticker import LogLocator

        from rl_design_space.report.generic.selection import text
        from rl_design_space.report.heatmap import SETTINGS, colour_bar, colour_cells, hatch, write

        def keys(names: tuple[str, ...]) -> pd.Series[str]:
            return frame[list(names)].map(text).agg("\n".join if names == self.cols else ", ".join, axis=1)

        table = frame.assign(row=keys(self.rows), column=keys(self.cols))
        values = table.pivot_table(index="row", columns="column", values="value", dropna=False, sort=False)
        measured = table["value"].dropna()
        low, high = (measured.min(), measured.max()) if len(measured) else (0.0, 1.0)
        norm = LogNorm(low, high) if low > 0 and high / low >= _DECADE else Normalize(low, high)
        size = [_WIDTH * max(len(values.columns), 3) + 2.6, _HEIGHT * max(len(values), 3) + 1.6]
        with mpl.rc_context(SETTINGS):
            figure, axis = plt.subplots(figsize=[min(side, _LONGEST) for side in size], layout="constrained")
            inks = colour_cells(axis, values, norm)
            rows, columns = values.index.tolist(), values.columns.tolist()
            for cell in table.to_dict("records"):
                y, x = rows.index(cell["row"]), columns.index(cell["column"])
                if math.isnan(cell["value"]):
                    hatch(axis, x, y, "")
                    continue
                between = interval(cell["low"], cell["high"])
                lines = [(0.36 if between else 0.5, number(cell["value"]), {"fontsize": 10, "fontweight": "bold"})]
                write(axis, x, y, [*lines, (0.72, between, {"fontsize": 6.5})], inks[y][x])
            axis.set_ylabel(", ".join(self.rows))
            axis.set_xlabel(", ".join(self.cols))
            axis.set_title(self.heading, fontsize=11)
            if low < high:
                ticks = LogLocator(subs=(1, 2, 5)) if isinstance(norm, LogNorm) else None
                bar = colour_bar(figure, [axis], norm, ticks=ticks, format=lambda value, _: number(value))
                bar.set_label(self.value)
        return figure

    def remarks(self, frame: pd.DataFrame) -> list[str]:
        """What is best, what is missing, and how to read it."""
        from rl_design_space.report.generic.selection import label

        names = [*self.rows, *self.cols]
        known = frame.dropna(subset="value")
        lines = []
        if len(known):
            ordered = known.sort_values("value").to_dict("records")
            for what, row in (("Least", ordered[0]), ("Most", ordered[-1])):
                lines.append(f"{what}: {number(row['value'])} with {label(names, [row[name] for name in names])}.")
        if missing := len(frame) - len(known):
            lines.append(f"Hatched: {missing} of {len(frame)} cells have no run.")
        return [*lines, "Small: the 95 % bootstrap interval over periods."]
