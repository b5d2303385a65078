"""A published table beside its cells as they were measured: heatmap, CSV and Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.published import compare_with_published
from rl_design_space.config.labels import own_labels
from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.cells import Line, colour_bar, colour_cells, hatch, write
from rl_design_space.report.larger_samples import larger_samples
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design, largest
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import interval, styled
from rl_design_space.report.written import Written

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader

Axis = Annotated[dict[str, str], Field(min_length=1, max_length=1)]
_WHOLE = ",.0f"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PublishedTable(Report):
    """Cells of a published table beside the same cells measured.

    Attributes:
        value: what a period contributes to its cell.
        panel, row, column: each one pair, the column's name in the CSV and the parameter of the points behind it.
        labels: how names and values read in the picture; values may stand without their parameter.
        published: the published number by panel, row and column.
        source: what the published numbers are called in picture and text.
        heavy_tail: a cell is marked whose 1 % of periods with most steps need so many times the mean, or more.
        larger_samples: study with more periods of some cells, which are shown where they are recorded; none if empty.
    """

    shows: str = "A heatmap for each panel: measured values with their intervals, and the published numbers"
    value: Literal["total_steps", "total_steps_scaled"]
    panel: Axis
    row: Axis
    column: Axis
    labels: dict[str, str]
    published: dict[Any, dict[Any, dict[Any, float]]]
    source: str = "published"
    heavy_tail: float = 3
    larger_samples: str = ""

    choosable: ClassVar[Sequence[str]] = ("scale", "colour_map")
    names_cells: ClassVar[bool] = True

    @property
    def axes(self) -> dict[str, str]:
        """Parameter by CSV column, of panel, row and column in this order."""
        return {**self.panel, **self.row, **self.column}

    def write(self, study: Study, reader: Reader, folder: Path) -> Written:
        runs = Runs.of_study(study, reader)
        if self.larger_samples:
            runs = runs.with_larger(*larger_samples(self.larger_samples, study, reader))
        return self.write_runs(runs, folder / study.name)

    def frames(self, runs: Runs) -> Frames:
        """Return the cells, see `analysis.published`; `planned` tells those that are points of the runs.

        Raises:
            ConfigError: several points are one cell, no point has such a parameter, or the value is not known.
        """
        runs.check(self.axes.values())
        points = self._points_by_cell(runs)
        cells = []
        for panel, rows in self.published.items():
            for row, columns in rows.items():
                for column, published in columns.items():
                    key = (panel, row, column)
                    keys = dict(zip(self.axes, key, strict=True))
                    measured = self._measured(runs, points[key]) if key in points else ()
                    cells.append({**keys, **compare_with_published(published, *measured), "planned": key in points})
                    cells[-1]["periods"] = len(measured[0]) if measured else 0
        return {MAIN: pd.DataFrame(cells)}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN].drop(columns=["top_percent", "planned"])}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def text(self, frames: Frames) -> list[str]:
        """Return the cells, and how far measured and published numbers lie apart."""
        cells = frames[MAIN]
        parts: list[str] = [table(self._shown(cells))]
        if cells["measured"].notna().any():
            parts.append(self._distance(cells.dropna(subset="measured")))
        periods = cells["periods"][cells["periods"] > 0].value_counts().sort_index()
        if len(periods) > 1:
            parts.append(f"Periods: {', '.join(f'{size:,} in {count} cells' for size, count in periods.items())}.")
        if outside := int((~cells["planned"]).sum()):
            parts.append(f"Not asked for: {outside} of {len(cells)} cells.")
        return [
            *parts,
            "Measured: mean over periods of the steps of all trials, with its 95 % interval over periods (BCa "
            "bootstrap; Hall's transformation of more than 2,000). Failed trials count with the steps up to the cap.",
            f"Heavy tail (†): the 1 % of periods with most steps need {self.heavy_tail:g} times the mean or more. Such "
            "a mean depends on few periods, published or measured, so its ratio says little.",
        ]

    def label(self, value: object) -> str:
        """Return how a name or value reads in the picture."""
        return self._labels.get(str(value), str(value))

    @cached_property
    def _labels(self) -> dict[str, str]:
        """Labels of columns and bare values; those of parameters and their values are for these, too."""
        return {**self._of_cells(own_labels()), **self.labels, **self._of_cells(self.labels)}

    def _of_cells(self, labels: Mapping[str, str]) -> dict[str, str]:
        found: dict[str, str] = {}
        for axis, parameter in self.axes.items():
            begin = f"{parameter}="
            found |= {name.removeprefix(begin): text for name, text in labels.items() if name.startswith(begin)}
            if parameter in labels:
                found[axis] = labels[parameter]
        return found

    def _shown(self, cells: pd.DataFrame) -> pd.DataFrame:
        """Return the cells as texts."""
        rows = []
        for cell in cells.to_dict("records"):
            values = ["missing" if cell["planned"] else "not asked for", "", "", ""]
            if not np.isnan(cell["measured"]):
                tail = " †" if cell["top_percent"] >= self.heavy_tail else ""
                failed = f"{cell['failed_periods']:.1%} ({interval(cell['failed_low'], cell['failed_high'], '.1%')})"
                values = [
                    f"{cell['measured']:,.0f}",
                    interval(cell["ci_low"], cell["ci_high"], _WHOLE),
                    f"{cell['ratio']:.3f}",
                    f"{failed}{tail}",
                ]
            rows.append([*(cell[axis] for axis in self.axes), f"{cell['paper']:,.0f}", *values])
        header = [*self.axes, self.source, "measured", "95 % interval", "ratio", "periods with a failed trial"]
        return pd.DataFrame(rows, columns=header)

    def _distance(self, measured: pd.DataFrame) -> str:
        """Return how far measured and published numbers lie apart, for each panel."""
        (panel,) = self.panel
        parts = []
        for name, here in measured.groupby(panel, sort=False):
            log_ratio = np.log(here["ratio"])
            rms, largest = np.expm1(np.sqrt((log_ratio**2).mean())), np.expm1(log_ratio.abs().max())
            parts.append(f"{self.label(name)}: rms {rms:.1%}, largest {largest:.1%}")
        return f"Distance from the published numbers (log ratio): {'; '.join(parts)}."

    def _measured(self, runs: Runs, seeds: Sequence[Point]) -> tuple[FloatArray, NDArray[np.bool_]] | tuple[()]:
        """Return what each period contributes to its cell, and whether it has a failed trial; nothing if missing."""
        result = runs.pooled(seeds)
        if result is None:
            return ()
        values = [values for point in seeds if (values := runs.values(point, self.value)) is not None]
        if len(values) < len(seeds):
            expected = "needs square worlds; should be total_steps for others"
            raise ConfigError.at("study.report.value", self.value, expected)
        return np.concatenate(values), np.logical_not(result.success.all(axis=1))

    def _points_by_cell(self, runs: Runs) -> dict[tuple[Any, ...], list[Point]]:
        """Return the points of each cell, one for each seed; periods of different designs are not averaged.

        Of designs that differ in their number of periods alone, the largest that is recorded is the cell.

        Raises:
            ConfigError: several designs are one cell.
        """
        cells: dict[tuple[Any, ...], list[Point]] = {}
        for seeds in by_design(largest(runs.points)):
            first = cells.setdefault(seeds[0].key(self.axes.values()), seeds)
            if first is not seeds:
                names = ", ".join(differing([first[0].parameters, seeds[0].parameters]))
                raise ConfigError(f"{names}: several values for one cell of the table; choose one of them")
        return cells


@styled()
def _draw(cells: pd.DataFrame, look: PublishedTable) -> Figure:
    """Draw one heatmap for each panel: the measured value, and below it interval, periods, published number and ratio.

    Args:
        cells: as `PublishedTable.frames` returns them; panel, row and column first.
        look: the report.
    """
    panel, row, column = cells.columns[:3]
    panels = list(cells[panel].unique())
    measured = cells["measured"].dropna()
    is_log = look.is_log(measured, by_itself=True)
    norm = (LogNorm if is_log else Normalize)(*((measured.min(), measured.max()) if len(measured) else (1, 10)))
    figure, axes = plt.subplots(
        1, len(panels), figsize=(5.4 * len(panels) + 0.6, 5.0), layout="constrained", squeeze=False
    )
    for axis, name in zip(axes[0], panels, strict=True):
        here = cells[cells[panel] == name]
        values = here.pivot_table(index=row, columns=column, values="measured", dropna=False, sort=False)
        inks = colour_cells(axis, values, norm, square=True, colour_map=look.cells_map)
        _write_cells(axis, here, values, inks, look.source, look.heavy_tail)
        axis.set_title(look.label(name), fontsize=11)
        axis.set_xlabel(look.label(column))
        axis.set_ylabel(look.label(row))
    ticks = LogLocator(subs=(1, 2, 5)) if is_log else None
    bar = colour_bar(figure, axes[0].tolist(), norm, look.cells_map, shrink=0.8, ticks=ticks, format="{x:,.0f}")
    bar.set_label(f"measured{', logarithmic' if is_log else ''}")
    figure.suptitle(look.title, fontsize=12)
    figure.supxlabel(
        "Large: mean over periods, with its 95 % interval. Failures: share of periods in which a trial missed the "
        f"goal.\n† heavy tail: the 1 % of periods with most steps need {look.heavy_tail:g} times the mean or more.",
        fontsize=8,
    )
    return figure


def _write_cells(
    axis: Axes, cells: pd.DataFrame, values: pd.DataFrame, inks: list[list[str]], source: str, heavy_tail: float
) -> None:
    """Write into every cell of a panel; hatch those that were not measured."""
    rows, columns = values.index.tolist(), values.columns.tolist()
    for cell in cells.to_dict("records"):
        y, x = rows.index(cell[values.index.name]), columns.index(cell[values.columns.name])
        if np.isnan(cell["measured"]):
            hatch(axis, x, y, f"not measured\n{source} {cell['paper']:,.0f}")
            continue
        failures = cell["failed_periods"]
        remark = "" if failures == 0 else f"failures {failures:.0%}" if failures >= 0.01 else "failures <1%"
        remark += " †" if cell["top_percent"] >= heavy_tail else ""
        lines: list[Line] = [
            (0.22, f"{cell['measured']:,.0f}", {"fontsize": 13, "fontweight": "bold"}),
            (0.40, interval(cell["ci_low"], cell["ci_high"], _WHOLE), {"fontsize": 8}),
            (0.53, f"{cell['periods']:,} periods", {"fontsize": 7}),
            (0.67, f"{source} {cell['paper']:,.0f}", {}),
            (0.80, f"ratio {cell['ratio']:.2f}", {}),
            (0.92, remark, {"fontsize": 8, "style": "italic"}),
        ]
        write(axis, x, y, lines, inks[y][x])
