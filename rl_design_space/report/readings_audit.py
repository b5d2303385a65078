"""The audit of readings: which reading of a text fits its own numbers best."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._markdown import code
from rl_design_space._strict import STRICT
from rl_design_space.analysis.fit import fit
from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.plan.study import load_study
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.cells import hatch_row
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import BLUE, GREY, interval, styled
from rl_design_space.tracking.selection import Where

_COLUMNS = [
    "reading", "panel", "cells", "of", "rms", "ci_low", "ci_high", "bias", "bias_low", "bias_high", "largest",
]  # fmt: skip
_SAID = ["title", "says", "decided"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ReadingsAudit(Report):
    """Readings ranked by how well a published table fits under each.

    Attributes:
        table: the study whose report has the published numbers, a `PublishedTable`.
        decided: values of parameters that a point has unless its reading says otherwise.
        readings: what each reading says, by its name; the one that says nothing is the one that was decided for.
    """

    shows: str = "Readings ranked by their distance from the published numbers, with intervals"
    table: str
    decided: Where
    readings: dict[str, Where]

    def frames(self, runs: Runs) -> Frames:
        """Return one row for each reading and panel of the table, the best fit first; readings without all cells last.

        Returns:
            reading, panel, cells (recorded), of (published), rms, ci_low, ci_high, bias, bias_low, bias_high, largest;
            the last seven as log ratios, NaN unless all cells are there. Not written: title (of the panel), says (what
            the reading says), decided (whether it is the one that was decided for).
        """
        published = self.published_table()
        rows = []
        for panel, panel_rows in published.published.items():
            numbers = {(row, column): n for row, columns in panel_rows.items() for column, n in columns.items()}
            decided = self.points(runs, published, panel, {})
            for reading, says in self.readings.items():
                points = self.points(runs, published, panel, says)
                if says and points == decided:
                    continue  # it makes no difference here
                found: list[tuple[FloatArray, float]] = []
                for cell, number in numbers.items():
                    if cell in points and runs.pooled(points[cell]):
                        values = [runs.values(point, published.value) for point in points[cell]]
                        found.append((np.concatenate([each for each in values if each is not None]), number))
                fitted: tuple[float, ...] = (float("nan"),) * 7
                if len(found) == len(numbers):
                    fits = fit(found)
                    fitted = (*fits.rms, *fits.bias, fits.largest)
                said = (published.label(panel), _in_words(says), not says)
                rows.append((reading, panel, len(found), len(numbers), *fitted, *said))
        return {MAIN: pd.DataFrame(rows, columns=[*_COLUMNS, *_SAID]).sort_values(["panel", "rms"], ignore_index=True)}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN][_COLUMNS]}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.title)

    def text(self, frames: Frames) -> list[str]:
        """Return the ranking of each panel."""
        parts = []
        for title, fits in frames[MAIN].groupby("title", sort=False):
            rows = [[fitted["reading"], fitted["says"], *_numbers(fitted)] for fitted in fits.to_dict("records")]
            header = ["reading", "says", "rms log ratio", "95 % interval", "mean ratio", "95 % interval", "largest"]
            parts += [f"## {title}", table(pd.DataFrame(rows, columns=header))]
        return [
            *parts,
            "A log ratio of 0.1 is a tenth too much or too little. The rms is over the cells of a panel; the interval "
            "is over periods.",
        ]

    def published_table(self) -> PublishedTable:
        """Return the report with the published numbers.

        Raises:
            ConfigError: the study has another report.
        """
        with shipped_config():
            report = load_study(self.table, ()).report()
        if not isinstance(report, PublishedTable):
            raise ConfigError.at("report.table", self.table, "should be a study whose report is a PublishedTable")
        return report

    def points(self, runs: Runs, published: PublishedTable, panel: Any, says: Where) -> dict[Any, list[Point]]:
        """Return the points of a panel under a reading, one for each seed, by row and column of the table.

        Raises:
            ConfigError: several designs are one cell.
        """
        wanted = {**self.decided, **says}
        cells: dict[Any, list[Point]] = {}
        for seeds in by_design(runs.points):
            if seeds[0].allows(wanted):
                here, row, column = seeds[0].key(published.axes.values())
                if here == panel and (first := cells.setdefault((row, column), seeds)) is not seeds:
                    names = ", ".join(differing([first[0].parameters, seeds[0].parameters]))
                    raise ConfigError(f"{names}: several values for one cell under one reading; choose one of them")
        return cells


def _in_words(says: Where) -> str:
    return ", ".join(code(f"{name}={value}") for name, value in says.items()) or "the defaults"


def _numbers(fitted: Mapping[Any, Any]) -> list[str]:
    if np.isnan(fitted["rms"]):
        return [f"missing: {fitted['of'] - fitted['cells']} cells", "", "", "", ""]
    ratio, low, high = (np.exp(fitted[name]) for name in ("bias", "bias_low", "bias_high"))
    return [
        f"{fitted['rms']:.3f}",
        interval(fitted["ci_low"], fitted["ci_high"], ".3f"),
        f"{ratio:.3f}",
        interval(low, high, ".3f"),
        f"{np.expm1(fitted['largest']):.1%}",
    ]


@styled()
def _draw(fits: pd.DataFrame, title: str) -> Figure:
    """Draw one panel for each panel of the table: the readings, best fit on top, with their distance."""
    panels = list(fits["title"].unique())
    longest = int(fits.groupby("title")["reading"].count().max())
    figure, axes = plt.subplots(
        1, len(panels), figsize=(6.2 * len(panels), 1.6 + 0.27 * longest), layout="constrained", squeeze=False
    )
    for axis, panel in zip(axes[0], panels, strict=True):
        _draw_panel(axis, fits[fits["title"] == panel].reset_index(drop=True))
        axis.set_title(panel, fontsize=11)
    figure.suptitle(title, fontsize=12)
    figure.supxlabel("Root of the mean squared log ratio, measured / published, with its 95 % interval", fontsize=9)
    return figure


def _draw_panel(axis: Axes, fits: pd.DataFrame) -> None:
    for row, fitted in enumerate(fits.to_dict("records")):
        if np.isnan(fitted["rms"]):
            hatch_row(axis, row, f"missing: {fitted['of'] - fitted['cells']} of {fitted['of']} cells")
            continue
        colour = BLUE if fitted["decided"] else GREY
        axis.plot([fitted["ci_low"], fitted["ci_high"]], [row, row], color=colour, linewidth=2)
        axis.plot(fitted["rms"], row, marker="o", color=colour)
        sign = "too large" if fitted["bias"] > 0 else "too small"
        note = f"{fitted['rms']:.3f}  ({abs(np.expm1(fitted['bias'])):.0%} {sign})"
        axis.annotate(
            note, (fitted["ci_high"], row), xytext=(5, 0), textcoords="offset points", va="center", fontsize=8
        )
    axis.set_yticks(range(len(fits)), fits["reading"])
    for label, decided in zip(axis.get_yticklabels(), fits["decided"], strict=True):
        label.set_fontweight("bold" if decided else "normal")
    axis.set_ylim(len(fits) - 0.4, -0.6)
    axis.set_xlim(left=0)
    axis.margins(x=0.35)
    axis.grid(axis="x", color="0.9")
    axis.spines[["top", "right"]].set_visible(False)
