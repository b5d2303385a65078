"""The picture of the ledger of claims: a line for each part."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from rl_design_space.report.style import BLUE, LIGHT_GREEN, VERMILION, styled

#: Colour and marker by the state of a part.
_LOOKS = {"holds": (BLUE, "o"), "fails": (VERMILION, "X"), "unclear": ("#6f6f6f", "D")}
#: Where the names of the claims stand, in widths of a part's axis.
_RIGHT = 1.55
#: Height of a part in inches, and the longest description of one in characters.
_HEIGHT, _LONGEST = 0.25, 78
#: Behind the parts of verdicts that came later.
_GREY = "0.94"


@styled(font_size=8)
def drawn(parts: pd.DataFrame, later_parts: pd.DataFrame | None, title: str) -> Figure:
    """Draw one line for each part, on an axis of its own, scaled to show value, interval and claimed range.

    Args:
        parts: as `claims_judged.parts_frame` returns them.
        later_parts: those of the later verdicts, which stand on grey below the registered ones; None if there are none.
        title: of the picture.
    """
    lines = _lines(parts, later_parts)
    figure, axis = plt.subplots(figsize=(12.5, 1.6 + _HEIGHT * max(len(lines), 4)), layout="constrained")
    for row, part in enumerate(lines.to_dict("records")):
        _draw_part(axis, row, part)
    names = [textwrap.shorten(what, _LONGEST, placeholder=" …") for what in lines["what"]]
    axis.set_yticks(range(len(lines)), names)
    for (claim, later), rows in lines.reset_index().groupby(["claim", "later"], sort=False)["index"]:
        verdict = lines.loc[rows.iloc[0], "verdict"]
        label = (": " if len(rows) == 1 else "\n").join((f"{claim}, later" if later else str(claim), verdict))
        axis.text(_RIGHT, rows.mean(), label, va="center", fontsize=8, fontweight="bold")
        axis.axhline(rows.iloc[-1] + 0.5, color="0.85", linewidth=0.8, clip_on=False)
        if later:
            axis.axhspan(rows.iloc[0] - 0.5, rows.iloc[-1] + 0.5, color=_GREY, zorder=0)
    axis.set_ylim(max(len(lines), 1) - 0.4, -0.8)
    axis.set_xlim(-0.03, _RIGHT + 0.32)
    axis.set_xticks([])
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
    marks = [Line2D([], [], color=colour, marker=marker, label=state) for state, (colour, marker) in _LOOKS.items()]
    fields = [Rectangle((0, 0), 1, 1, color=LIGHT_GREEN, label="range that the claim gives")]
    if later_parts is not None:
        fields.append(Rectangle((0, 0), 1, 1, color=_GREY, label="criteria that came later"))
    figure.legend(handles=[*marks, *fields], loc="outside lower center", ncols=5, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def _lines(parts: pd.DataFrame, later_parts: pd.DataFrame | None) -> pd.DataFrame:
    """Return the parts of both verdicts, claim by claim."""
    frames = [parts.assign(later=False)]
    if later_parts is not None:
        frames.append(later_parts.assign(later=True))
    joined = pd.concat([frame for frame in frames if len(frame)] or frames[:1], ignore_index=True)
    place = {claim: number for number, claim in enumerate(dict.fromkeys(joined["claim"]))}
    order = joined["claim"].map(place)
    return joined.assign(place=order).sort_values(["place", "later"], kind="stable", ignore_index=True)


def _draw_part(axis: Axes, row: int, part: Mapping[Any, Any]) -> None:
    if np.isnan(part["value"]):
        axis.text(0.5, row, "not defined", ha="center", va="center", fontsize=7)
        return
    names = ("value", "ci_low", "ci_high", "claimed_low", "claimed_high")
    numbers = [part[name] for name in names if np.isfinite(part[name])]
    low, high = min(numbers), max(numbers)
    margin = 0.35 * (high - low) or 0.1 * abs(high) or 1.0
    low, high = low - margin, high + margin

    def at(value: float) -> float:
        return float(np.clip((value - low) / (high - low), 0, 1))

    begin, end = at(part["claimed_low"]), at(part["claimed_high"])
    axis.barh(row, end - begin, left=begin, height=0.7, color=LIGHT_GREEN, zorder=1)
    colour, marker = _LOOKS[part["state"]]
    axis.plot([at(part["ci_low"]), at(part["ci_high"])], [row, row], color=colour, linewidth=2, zorder=2)
    axis.plot(at(part["value"]), row, color=colour, marker=marker, markersize=5, zorder=3)
    ends = f"{part['ci_low']:.3g} – {part['ci_high']:.3g}"
    bounds = [f"{part[name]:.3g}" for name in ("claimed_low", "claimed_high") if np.isfinite(part[name])]
    sign = "≥ " if np.isinf(part["claimed_high"]) else "≤ " if np.isinf(part["claimed_low"]) else ""
    text = f"{part['sign']}{part['value']:.3g} ({ends}); claimed {sign}{' – '.join(bounds)}"
    axis.text(1.02, row, text, va="center", fontsize=7)
