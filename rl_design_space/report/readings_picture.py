"""The picture of an audit of readings: how much less likely each makes the numbers of each panel, and of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rl_design_space.report.cells import hatch_row
from rl_design_space.report.style import BLUE, GREY, VERMILION, styled

#: Readings that the picture shows; the files have all of them.
SHOWN = 24


@styled()
def draw_readings(
    joint: pd.DataFrame, fits: pd.DataFrame, panels: Mapping[str, str], title: str, limit: float
) -> Figure:
    """Draw the readings, the most likely one on top: an axis for each panel, and one for all of them.

    Args:
        joint: a row for each reading, see `ReadingsAudit.frames`.
        fits: a row for each reading and panel.
        panels: title of each panel, by its name in the columns.
        title: heading of the picture.
        limit: how many times less likely than the best of a panel a reading may be to fit it.
    """
    shown = joint.head(SHOWN)
    axes: Sequence[Axes]
    figure, axes = plt.subplots(
        1,
        len(panels) + 1,
        figsize=(3.4 + 3.3 * (len(panels) + 1), 1.7 + 0.27 * len(shown)),
        layout="constrained",
        sharey=True,
    )
    for axis, (panel, heading) in zip(axes, panels.items(), strict=False):
        behind = joint[panel].max() - shown[panel]
        _draw_panel(axis, shown, behind, limit, _notes(shown, fits[fits["panel"] == panel]))
        axis.set_title(heading, fontsize=11)
    _draw_panel(axes[-1], shown, shown["behind"], limit, [f"P = {n:.0f}" for n in shown["periods"].fillna(0)])
    axes[-1].set_title("both together" if len(panels) == 2 else "all together", fontsize=11)
    axes[0].set_yticks(range(len(shown)), shown["reading"])
    for label, decided in zip(axes[0].get_yticklabels(), shown["decided"], strict=True):
        label.set_fontweight("bold" if decided else "normal")
    axes[0].set_ylim(len(shown) - 0.4, -0.6)
    more = f", the first {len(shown)} of {len(joint)} readings" if len(joint) > len(shown) else ""
    figure.suptitle(title + more, fontsize=12)
    figure.supxlabel(
        f"Times less likely than the best reading, as a power of ten; dashed: {limit:g} times. P: periods of a mean. "
        "Blue: as decided. Orange: fits one panel and not another.",
        fontsize=9,
    )
    return figure


def _notes(shown: pd.DataFrame, fits: pd.DataFrame) -> list[str]:
    """Return by how much each reading is off in a panel, on average; nothing where it makes no difference there."""
    bias = fits.set_index("reading")["bias"].reindex(shown["reading"])
    return [
        "" if np.isnan(each) else f"{abs(np.expm1(each)):.0%} too {'large' if each > 0 else 'small'}" for each in bias
    ]


def _draw_panel(axis: Axes, shown: pd.DataFrame, behind: pd.Series[float], limit: float, notes: Sequence[str]) -> None:
    decades = behind.to_numpy(float) / np.log(10)
    for row, (reading, far, note) in enumerate(zip(shown.to_dict("records"), decades, notes, strict=True)):
        if np.isnan(reading["joint"]):
            hatch_row(axis, row, f"missing: {reading['of'] - reading['cells']} of {reading['of']} cells")
            continue
        colour = BLUE if reading["decided"] else VERMILION if reading["one_panel"] else GREY
        axis.barh(row, far, height=0.55, color=colour, alpha=0.75)
        axis.plot(far, row, marker="o", markersize=4, color=colour)
        label = {"facecolor": "white", "linewidth": 0, "pad": 0.6}
        axis.annotate(note, (far, row), xytext=(6, 0), textcoords="offset points", va="center", fontsize=8, bbox=label)
    axis.axvline(np.log10(limit), color="black", linestyle="--", linewidth=0.8)
    axis.set_xlim(0, max(1.4 * np.nanmax(decades, initial=0), 3))
    axis.grid(axis="x", color="0.9")
    axis.spines[["top", "right"]].set_visible(False)
