"""Heatmaps of grids that a Q-matrix is learned on and grids that it is used on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.ratios import plain_ratio, ratio_of
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.design import stages_of
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.cells import Line, colour_bar, colour_cells, hatch, write
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design, having
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import interval, number, styled
from rl_design_space.tracking.selection import Where

#: Row of what has begun with nothing.
NOTHING = "nothing"
_TARGET = "world.size"
_COLUMNS = ["source", "target", "value", "low", "high", "median", "runs"]
_PERCENT = ".0%"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TransferMap(Report):
    """A heatmap of source and target size for each combination of some parameters.

    The source is the grid of the first stage, the target that of the point.

    Attributes:
        value: measure that is shown, as a share: such as `{solved: null, stage: 2}`.
        saved: whether 1 − the measure / that of what has begun with nothing is shown instead.
        nothing: values of the points that begin with nothing: the last row, or what the others are compared with.
        down: parameters whose values make the rows of panels.
        across: parameter whose values make the columns of panels.
        named: pairs of source and target whose numbers are printed.
    """

    shows: str = "A heatmap for each representation, carry rule and exploration: source size by target size"
    value: MeasureName
    saved: bool = False
    nothing: Annotated[Where, Field(min_length=1)]
    down: Annotated[tuple[Text, ...], Field(strict=False, min_length=1)] = ("exploration", "curriculum.carry")
    across: Text = "representation"
    named: Annotated[tuple[tuple[int, int], ...], Field(strict=False)] = ((10, 30),)

    choosable: ClassVar[Sequence[str]] = ("colour_map",)

    def frames(self, runs: Runs) -> Frames:
        """Return values of `down` and `across`, source, target, value, low, high, median, runs: a row for each cell.

        `median` is the value with medians over periods in the place of means, NaN for shares.
        """
        runs.check([*self.down, self.across, _TARGET, *self.nothing])
        begun_with_nothing = having(runs.points, self.nothing)
        others = [point for point in runs.points if point not in begun_with_nothing]
        rows = []
        for seeds in by_design(others):
            baseline = self._baseline(seeds[0], begun_with_nothing)
            rows.append(self._cell(runs, seeds, baseline, _source(seeds[0])))
        if not self.saved:
            panels = {point.key(self.down) for point in others}
            for seeds in by_design(begun_with_nothing):
                cell = self._cell(runs, seeds, [], NOTHING)
                rows += [{**cell, **dict(zip(self.down, panel, strict=True))} for panel in panels]
        return {MAIN: pd.DataFrame(rows, columns=[*self.down, self.across, *_COLUMNS])}

    def _baseline(self, point: Point, of: Sequence[Point]) -> list[Point]:
        """Return the points that begin with nothing on the target of a point."""
        where = {name: point.parameters[name] for name in (self.across, _TARGET)}
        designs = by_design(having(of, where))
        return designs[0] if len(designs) == 1 else []

    def _cell(self, runs: Runs, seeds: Sequence[Point], baseline: Sequence[Point], source: Any) -> dict[str, Any]:
        value, median = Estimate(math.nan, math.nan, math.nan), math.nan
        if self.saved:
            one, other = runs.pooled(seeds), runs.pooled(baseline) if baseline else None
            if one and other:
                ratio = ratio_of(self.value, one, other)
                value = Estimate(1 - ratio.value, 1 - ratio.high, 1 - ratio.low)
                median = 1 - plain_ratio(f"{self.value},statistic=median", one, other)
        elif all(point.run for point in seeds):
            found = runs.estimate(seeds, self.value)
            value = Estimate(found.value, found.low, found.high)
        for point in seeds:
            runs.forget(point)
        first = seeds[0]
        keys = {name: first.parameters[name] for name in (*self.down, self.across)}
        known = {**value._asdict(), "median": median, "runs": sum(point.run is not None for point in seeds)}
        return {**keys, "source": source, "target": first.parameters[_TARGET], **known}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.down, self.across, self)

    def numbers(self, frames: Frames) -> list[str]:
        """Return for each panel the named cells, and the ranges from smaller and from larger grids."""
        lines = []
        for name, cells in _panels(frames[MAIN], self.down, self.across):
            known = cells.dropna(subset="value")
            sources = known[known["source"] != NOTHING].astype({"source": int})
            parts = [
                f"{source} → {target}: {_shown(cell)}"
                for source, target in self.named
                for cell in sources[(sources["source"] == source) & (sources["target"] == target)].to_dict("records")
            ]
            for what, some in (
                ("smaller to larger", sources[sources["source"] < sources["target"]]),
                ("equal", sources[sources["source"] == sources["target"]]),
                ("larger to smaller", sources[sources["source"] > sources["target"]]),
            ):
                if len(some):
                    parts.append(f"{what} {_percent(some['value'].min())} to {_percent(some['value'].max())}")
            lines.append(f"{name}: {', '.join(parts) or 'missing'}")
        return lines

    def text(self, frames: Frames) -> list[str]:
        """Return all cells as a table."""
        cells = frames[MAIN]
        rows = [
            [
                *(_words(cell[name]) for name in (*self.down, self.across)), cell["source"], cell["target"],
                _percent(cell["value"]), interval(cell["low"], cell["high"], _PERCENT), _percent(cell["median"]),
            ]
            for cell in cells.to_dict("records")
        ]  # fmt: skip
        header = [*self.down, self.across, "source", "target", "value", "95 % interval", "by medians"]
        shown = table(pd.DataFrame(rows, columns=header))
        what = "1 − the steps / those of what begins with nothing" if self.saved else "a share of trials"
        missing = int(cells["value"].isna().sum())
        return [
            "\n".join(f"- {line}" for line in self.numbers(frames)),
            f"The value is {what}; its measure is `{self.value}`. Intervals are bootstrap intervals over periods"
            f"{', paired by layout' if self.saved else ''}.",
            *([f"Hatched: {missing} of {len(cells)} cells are missing."] if missing else []),
            shown,
        ]


def _source(point: Point) -> int:
    """Return the size of the grid on which a point is learned first."""
    stages = stages_of(point.planned.point)
    first = stages[0].point if stages else point.planned.point
    return int(first.world.shape[0])


def _words(value: Any) -> str:
    return str(value).replace("_", " ")


def _percent(value: float) -> str:
    return "" if math.isnan(value) else number(value, _PERCENT)


def _shown(cell: dict[Any, Any]) -> str:
    return f"{number(cell['value'], _PERCENT)} ({interval(cell['low'], cell['high'], _PERCENT)})"


def _panels(cells: pd.DataFrame, down: Sequence[str], across: str) -> Iterator[tuple[str, pd.DataFrame]]:
    for key, panel in cells.groupby([*down, across], sort=False):
        yield ", ".join(map(_words, reversed(key))), panel


@styled()
def _draw(cells: pd.DataFrame, down: Sequence[str], across: str, look: TransferMap) -> Figure:
    columns = list(dict.fromkeys(cells[across]))
    rows = list(dict.fromkeys(zip(*(cells[name] for name in down), strict=True)))
    measured = cells["value"].dropna()
    norm = Normalize(min(0.0, *measured, 0.0), 1.0)
    figure, axes = plt.subplots(
        max(1, len(rows)), max(1, len(columns)), layout="constrained", squeeze=False,
        figsize=(3.6 * max(1, len(columns)) + 1, 2.7 * max(1, len(rows)) + 0.8),
    )  # fmt: skip
    for row, of_row in zip(rows, axes, strict=False):
        for column, axis in zip(columns, of_row, strict=False):
            here = cells[cells[across] == column]
            for name, value in zip(down, row, strict=True):
                here = here[here[name] == value]
            _draw_panel(axis, here, norm, look.cells_map)
            axis.set_title(f"{_words(column)}\n{', '.join(map(_words, row))}", fontsize=9)
    for axis in axes[-1]:
        axis.set_xlabel("used on")
    for axis in axes[:, 0]:
        axis.set_ylabel("learned on")
    bar = colour_bar(figure, list(axes.flat), norm, look.cells_map, format=lambda value, _: _percent(value), shrink=0.6)
    bar.set_label("steps saved" if look.saved else "share of trials")
    figure.suptitle(look.title, fontsize=12)
    return figure


def _draw_panel(axis: Axes, cells: pd.DataFrame, norm: Normalize, colour_map: str) -> None:
    sources = sorted({each for each in cells["source"] if each != NOTHING}, reverse=True)
    places = [*sources, *([NOTHING] if NOTHING in set(cells["source"]) else [])]
    targets = sorted(set(cells["target"]))
    values = pd.DataFrame(np.nan, index=places, columns=targets)
    for cell in cells.to_dict("records"):
        values.loc[cell["source"], cell["target"]] = cell["value"]
    inks = colour_cells(axis, values.clip(lower=norm.vmin), norm, colour_map=colour_map)
    for cell in cells.to_dict("records"):
        x, y = targets.index(cell["target"]), places.index(cell["source"])
        if math.isnan(cell["value"]):
            hatch(axis, x, y, "")
            continue
        lines: list[Line] = [
            (0.36, _percent(cell["value"]), {"fontsize": 9, "fontweight": "bold"}),
            (0.74, interval(cell["low"], cell["high"], _PERCENT), {"fontsize": 5.5}),
        ]
        write(axis, x, y, lines, inks[y][x])
    axis.set_xlabel("")
    axis.set_ylabel("")
