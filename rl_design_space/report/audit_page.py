"""The audit of readings as a picture and as Markdown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt

from rl_design_space.report.markdown import made_by, missing_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rl_design_space.plan.study import Study
    from rl_design_space.report.audit import ReadingsAudit
    from rl_design_space.report.published_table import PublishedTable
    from rl_design_space.report.study_runs import Runs

_SETTINGS: dict[Any, Any] = {"svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "font.size": 9}
_DECIDED, _OTHER = "#0072b2", "#555555"


def draw(fits: pd.DataFrame, table: PublishedTable, title: str) -> Figure:
    """One panel a panel of the table: the readings, best fit on top, with their distance from the paper's numbers.

    Args:
        fits: as `ReadingsAudit.frame` returns them; the first reading of all is the one that was decided for.
        table: with the labels.
        title: of the picture.
    """
    panels = list(dict.fromkeys(fits["panel"]))
    longest = int(fits.groupby("panel")["reading"].count().max())
    with mpl.rc_context(_SETTINGS):
        figure, axes = plt.subplots(
            1, len(panels), figsize=(6.2 * len(panels), 1.6 + 0.27 * longest), layout="constrained", squeeze=False
        )
        for axis, panel in zip(axes[0], panels, strict=True):
            _draw_panel(axis, fits[fits["panel"] == panel].reset_index(drop=True))
            axis.set_title(table.label(panel), fontsize=11)
        figure.suptitle(title, fontsize=12)
        figure.supxlabel("Root of the mean squared log ratio, measured / published, with its 95 % interval", fontsize=9)
    return figure


def _draw_panel(axis: Axes, fits: pd.DataFrame) -> None:
    for row, fitted in enumerate(fits.to_dict("records")):
        if np.isnan(fitted["rms"]):
            note = f"missing: {fitted['of'] - fitted['cells']} of {fitted['of']} cells"
            axis.barh(
                row, 1, height=0.6, transform=axis.get_yaxis_transform(), hatch="///", fill=False, edgecolor="0.7"
            )
            axis.text(
                0.5, row, note, transform=axis.get_yaxis_transform(), ha="center", va="center", backgroundcolor="w"
            )
            continue
        colour = _DECIDED if fitted["reading"] == "as decided" else _OTHER
        axis.plot([fitted["ci_low"], fitted["ci_high"]], [row, row], color=colour, linewidth=2)
        axis.plot(fitted["rms"], row, marker="o", color=colour)
        sign = "too large" if fitted["bias"] > 0 else "too small"
        text = f"{fitted['rms']:.3f}  ({abs(np.expm1(fitted['bias'])):.0%} {sign})"
        axis.annotate(
            text, (fitted["ci_high"], row), xytext=(5, 0), textcoords="offset points", va="center", fontsize=8
        )
    axis.set_yticks(range(len(fits)), fits["reading"])
    for label in axis.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() == "as decided" else "normal")
    axis.set_ylim(len(fits) - 0.4, -0.6)
    axis.set_xlim(left=0)
    axis.margins(x=0.35)
    axis.grid(axis="x", color="0.9")
    axis.spines[["top", "right"]].set_visible(False)


def audit_text(study: Study, fits: pd.DataFrame, table: PublishedTable, audit: ReadingsAudit, runs: Runs) -> str:
    """The ranking with its picture, the commands behind it, and how to read it."""
    lines = [
        f"# {audit.title}",
        "",
        f"![Readings ranked by their distance from the published numbers, with intervals]({study.name}.png)",
        "",
        made_by(study),
        "",
    ]
    for panel, here in fits.groupby("panel", sort=False):
        lines += [
            f"## {table.label(panel)}",
            "",
            "| reading | says | rms log ratio | 95 % interval | mean ratio | 95 % interval | largest |",
            "|---|---|---|---|---|---|---|",
            *(_row(fitted, audit) for fitted in here.to_dict("records")),
            "",
        ]
    return "\n".join([*lines, *missing_points(study, len(runs.missing)), _HOW_TO_READ, ""])


_HOW_TO_READ = (
    "A log ratio of 0.1 is a tenth too much or too little. The rms is over the cells of a panel; the interval is over "
    "periods, and the paper's own chance, of which it says nothing, comes on top: a reading is ruled out where it is "
    "much farther off than the best one, not where it is slightly. The direction cells have heavy tails, so their "
    "intervals are wide and say less. What each reading means is in `docs/decisions/0001-readings-of-the-paper.md`."
)


def _row(fitted: dict[Any, Any], audit: ReadingsAudit) -> str:
    says = ", ".join(f"`{name}={value}`" for name, value in audit.readings[fitted["reading"]].items()) or "the defaults"
    if np.isnan(fitted["rms"]):
        return f"| {fitted['reading']} | {says} | missing: {fitted['of'] - fitted['cells']} cells | | | | |"
    ratio, low, high = (np.exp(fitted[name]) for name in ("bias", "bias_low", "bias_high"))
    values = [
        f"{fitted['rms']:.3f}",
        f"{fitted['ci_low']:.3f} – {fitted['ci_high']:.3f}",
        f"{ratio:.3f}",
        f"{low:.3f} – {high:.3f}",
        f"{np.expm1(fitted['largest']):.1%}",
    ]
    return f"| {fitted['reading']} | {says} | {' | '.join(values)} |"
