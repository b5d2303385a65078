"""Table 2 as a picture and as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter

from rl_design_space.report.markdown import made_by, missing_points

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rl_design_space.plan.study import Study

_SETTINGS: dict[Any, Any] = {"svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "font.size": 9}
#: Column of the frame: how its marks look and what they are.
_MARKS = {
    "paper": ({"marker": "_", "markersize": 14, "markeredgewidth": 2, "linestyle": "none"}, "the paper's formula"),
    "met": (
        {"marker": "o", "markersize": 5, "linestyle": "--", "linewidth": 1, "fillstyle": "none"},
        "rows a period can meet",
    ),
    "learned": ({"marker": "o", "markersize": 5, "linestyle": "-", "linewidth": 1}, "rows that were learned"),
}
_COLOURS = ("#0072b2", "#d55e00", "#009e73")


def draw(sizes: pd.DataFrame, title: str, labels: Mapping[str, str]) -> Figure:
    """A panel a representation: sizes against the number of goals, logarithmic.

    Args:
        sizes: as `StateSpace.frame` returns them.
        title: of the picture.
        labels: how names read.
    """
    panels = list(dict.fromkeys(sizes["representation"]))
    with mpl.rc_context(_SETTINGS):
        figure, axes = plt.subplots(
            1, len(panels), figsize=(3.8 * len(panels), 4.4), sharey=True, layout="constrained", squeeze=False
        )
        for axis, name in zip(axes[0], panels, strict=True):
            here = sizes[sizes["representation"] == name]
            for (side, points), colour in zip(here.groupby("size"), _COLOURS, strict=False):
                for column, (style, meaning) in _MARKS.items():
                    label = f"{meaning}, {side}×{side}"
                    axis.plot(points["goals"], points[column], color=colour, label=label, **style)
            if here["met"].isna().any():
                missing = int(here["met"].isna().sum())
                axis.text(0.5, 0.02, f"{missing} points missing", transform=axis.transAxes, ha="center")
            axis.set_yscale("log")
            axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
            axis.set_title(labels.get(name, name), fontsize=11)
            axis.set_xlabel("goals n")
            axis.set_xticks(sorted(set(sizes["goals"])))
            axis.grid(color="0.92")
            axis.spines[["top", "right"]].set_visible(False)
        axes[0, 0].set_ylabel("rows of the Q-matrix, logarithmic")
        handles, names = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=2, frameon=False)
        figure.suptitle(title, fontsize=12)
    return figure


def state_space_text(study: Study, sizes: pd.DataFrame, title: str, labels: Mapping[str, str], missing: int) -> str:
    """The table with its picture and how to read it."""
    wrong = sizes[sizes["paper"] != sizes["formula"]]
    lines = [
        f"# {title}",
        "",
        f"![Rows of the Q-matrix by formula, met and learned, against the number of goals]({study.name}.png)",
        "",
        made_by(study),
        "",
        "| representation | grid | n | paper | all there can be | a period can meet | (95 %) | learned | (95 %) |",
        "|---|---|---|---|---|---|---|---|---|",
        *(_row(row, labels) for row in sizes.to_dict("records")),
        "",
        f"The formula of the paper gives {len(sizes) - len(wrong)} of its {len(sizes)} numbers.",
        "",
    ]
    lines += [
        *missing_points(study, missing),
        "Within one period the goals stay where they are, so a period meets at most n × cells observations, however "
        "many a representation can make. Learned are rows in which an action has another value than at the start. "
        "Distances on a grid of even side have one value more than the formula counts: 0 is one of them.",
        "",
    ]
    return "\n".join(lines)


def _row(row: dict[Any, Any], labels: Mapping[str, str]) -> str:
    name = labels.get(row["representation"], row["representation"])
    keys = [name, f"{row['size']}×{row['size']}", str(row["goals"]), f"{row['paper']:,}", f"{row['spanned']:,}"]
    if np.isnan(row["met"]):
        return f"| {' | '.join(keys)} | missing | | | |"
    values = [f"{row['met']:,.1f}", _interval(row, "met"), f"{row['learned']:,.1f}", _interval(row, "learned")]
    return f"| {' | '.join([*keys, *values])} |"


def _interval(row: dict[Any, Any], name: str) -> str:
    low, high = row[f"{name}_low"], row[f"{name}_high"]
    return "" if np.isnan(low) else f"{low:,.1f} – {high:,.1f}"
