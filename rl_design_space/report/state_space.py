"""The size of the state space by a published formula, as it is met, and as it is learned."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.statistics import mean_estimate
from rl_design_space.design import SizedRepresentation
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import BLUE, GREEN, VERMILION, interval, styled, tidy, write_in_full

_COLOURS = (BLUE, VERMILION, GREEN)
_DECIMAL = ",.1f"
#: Columns of whole numbers that may be missing, in this order behind the names of the row.
_WHOLE = ("paper", "formula", "spanned")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StateSpace(Report):
    """Rows of a Q-matrix for each representation, size and number of goals.

    Attributes:
        published: the published number by representation, size and number of goals, where there is one.
        labels: how names read; as they are if left out.
        source: what the published numbers are called in picture and text.
    """

    title: Text
    shows: str = "Rows of the Q-matrix by formula, met and learned, against the number of goals"
    published: dict[str, dict[int, dict[int, int]]] = Field(default_factory=dict)
    labels: dict[str, str] = Field(default_factory=dict)
    source: str = "published"

    names_cells: ClassVar[bool] = True

    def frames(self, runs: Runs) -> Frames:
        """Return one row for each point of the study.

        Returns:
            representation, size, goals; paper; formula, by the package; spanned, all observations that there can be
            (None where they are not known, as for a representation without `spanned_size`); met, rows that a period can
            meet, and learned, those that anything was learned for: means over periods with 95 % intervals, NaN where
            the point was not recorded.
        """
        rows = []
        for each in runs.points:
            planned, result = each.planned, runs.result(each)
            point, name = planned.point, planned.options["representation"]
            size, goals = point.world.shape[0], point.task.goals
            sizes: list[int | None] = [None, None]
            if isinstance(sized := point.representation, SizedRepresentation):
                sizes = [sized.published_size(point.world, goals), sized.spanned_size(point.world, goals)]
            published = self.published.get(name, {}).get(size, {}).get(goals)
            measured = (float("nan"),) * 6
            if result:
                met, learned = (mean_estimate(result.rows[:, i].astype(float)) for i in (0, 1))
                measured = (*met, *learned)
            rows.append((name, size, goals, published, *sizes, *measured))
        columns = ["representation", "size", "goals", "paper", "formula", "spanned", "met", "met_low", "met_high"]
        frame = pd.DataFrame(rows, columns=[*columns, "learned", "learned_low", "learned_high"])
        for place, column in enumerate(_WHOLE, start=3):
            if frame[column].isna().any():  # whole numbers stay whole beside missing ones
                frame[column] = pd.Series([row[place] for row in rows], dtype=object)
        return {MAIN: frame}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.title, self.labels, self.source)

    def text(self, frames: Frames) -> list[str]:
        """Return the sizes, and how many of the published ones the formula gives."""
        sizes = frames[MAIN]
        known = sizes.dropna(subset="paper")
        right = int((known["paper"] == known["formula"]).sum())
        formula = f"The published formula gives {right} of the {len(known)} published numbers."
        return [
            table(self._shown(sizes)),
            *([formula] if len(known) else []),
            "Within one period the goals stay where they are, so a period meets at most n × cells observations, "
            "however many a representation can make. Learned are rows in which an action has another value than at the "
            "start.",
        ]

    def _shown(self, sizes: pd.DataFrame) -> pd.DataFrame:
        rows = []
        for row in sizes.to_dict("records"):
            name = self.labels.get(row["representation"], row["representation"])
            counts = ["–" if pd.isna(row[which]) else f"{row[which]:,}" for which in ("paper", "spanned")]
            keys = [name, f"{row['size']}×{row['size']}", row["goals"], *counts]
            values = ["missing", "", "", ""]
            if not np.isnan(row["met"]):
                values = [*_with_interval(row, "met"), *_with_interval(row, "learned")]
            rows.append([*keys, *values])
        header = ["representation", "grid", "n", self.source, "all there can be", "a period can meet", "(95 %)"]
        return pd.DataFrame(rows, columns=[*header, "learned", "(95 %)"])


def _with_interval(row: Mapping[Any, Any], name: str) -> list[str]:
    return [f"{row[name]:{_DECIMAL}}", interval(row[f"{name}_low"], row[f"{name}_high"], _DECIMAL)]


@styled()
def _draw(sizes: pd.DataFrame, title: str, labels: Mapping[str, str], source: str) -> Figure:
    """Draw a panel for each representation: sizes against the number of goals, logarithmic."""
    thin: dict[str, Any] = {"marker": "o", "markersize": 5, "linewidth": 1}
    bar: dict[str, Any] = {"marker": "_", "markersize": 14, "markeredgewidth": 2, "linestyle": "none"}
    marks: dict[str, tuple[str, dict[str, Any]]] = {
        "paper": (f"formula ({source})", bar),
        "met": ("rows a period can meet", {**thin, "linestyle": "--", "fillstyle": "none"}),
        "learned": ("rows that were learned", {**thin, "linestyle": "-"}),
    }
    panels = list(sizes["representation"].unique())
    figure, axes = plt.subplots(
        1, len(panels), figsize=(3.8 * len(panels), 4.4), sharey=True, layout="constrained", squeeze=False
    )
    for axis, name in zip(axes[0], panels, strict=True):
        here = sizes[sizes["representation"] == name]
        for (side, points), colour in zip(here.groupby("size"), _COLOURS, strict=False):
            for column, (meaning, style) in marks.items():
                axis.plot(
                    points["goals"],
                    points[column].astype(float),
                    color=colour,
                    label=f"{meaning}, {side}×{side}",
                    **style,
                )
        if missing := int(here["met"].isna().sum()):
            axis.text(0.5, 0.02, f"{missing} points missing", transform=axis.transAxes, ha="center")
        axis.set_yscale("log")
        write_in_full(axis.yaxis)
        axis.set_title(labels.get(name, name), fontsize=11)
        axis.set_xlabel("goals n")
        axis.set_xticks(sorted(set(sizes["goals"])))
        tidy(axis)
    axes[0, 0].set_ylabel("rows of the Q-matrix, logarithmic")
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2, frameon=False)
    figure.suptitle(title, fontsize=12)
    return figure
