"""The text of an audit of readings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from rl_design_space.analysis.likelihood import PERIODS, STRAY
from rl_design_space.report.markdown import table
from rl_design_space.report.style import interval

#: Readings in a table.
_SHOWN = 10
#: From where on a number of times is a power of ten.
_MANY = 10_000


def likelihoods(joint: pd.DataFrame, titles: Mapping[Any, str], limit: float, named: int | None) -> list[str]:
    """Return the first readings by their likelihood over all panels.

    Args:
        joint: a row for each reading, see `ReadingsAudit.frames`.
        titles: of the panels.
        limit: how many times less likely than the best of a panel a reading may be to fit it.
        named: number of periods that the text names.
    """
    rows = []
    behind_named = joint["joint_at_named"].max() - joint["joint_at_named"]
    for reading, far in zip(joint.head(_SHOWN).to_dict("records"), behind_named, strict=False):
        parts = [f"{reading[panel]:.1f}" for panel in titles]
        numbers = [_times(reading["behind"]), f"{reading['joint']:.1f}", *parts, f"{reading['periods']:,.0f}"]
        numbers += [_times(far)] if named else []
        if np.isnan(reading["joint"]):
            numbers = [f"missing: {reading['of'] - reading['cells']} cells", *[""] * (len(numbers) - 1)]
        rows.append([reading["reading"], reading["says"], *numbers, _fits(reading, titles)])
    at_named = [f"times less likely at P = {named:,}"] if named else []
    header = ["reading", "says", "times less likely", "log likelihood", *titles.values(), "P", *at_named, "fits"]
    whole = joint.dropna(subset="joint")
    near = int((whole["behind"] <= math.log(limit)).sum())
    single = int((whole["one_panel"] != "").sum())
    return [
        "## All panels together",
        f"Of {len(whole)} readings, {near} are at most {limit:g} times less likely than the best one; {single} fit one "
        "panel and not another, which chance gives to some of so many.",
        table(pd.DataFrame(rows, columns=header)),
        "Log likelihood, and the part of each panel: sum over the cells of the log density of the published number, as "
        f"the mean of P periods under the reading. P ({PERIODS[0]:,} to {PERIODS[-1]:,}) is the one that makes it "
        f"largest, the same for all cells; {PERIODS[0]:,} says that some numbers lie farther off than chance puts "
        f"them. With probability {STRAY:g} a number is anything within a factor of 10, so that no cell alone rules a "
        f"reading out. A reading fits a panel that is at most {limit:g} times less likely under it than under the best "
        "reading of this panel. That one reading is the most likely of those tried does not mean that it is likely.",
    ]


def distances(fits: pd.DataFrame, titles: Mapping[Any, str]) -> list[str]:
    """Return the first readings of each panel by the distance of their means from the published ones.

    Args:
        fits: a row for each reading and panel, see `ReadingsAudit.frames`.
        titles: of the panels.
    """
    header = ["reading", "says", "rms log ratio", "95 % interval", "mean ratio", "95 % interval", "largest"]
    parts = []
    for panel, title in titles.items():
        shown = fits[fits["panel"] == panel].head(_SHOWN).to_dict("records")
        rows = [[fitted["reading"], fitted["says"], *_distance(fitted)] for fitted in shown]
        parts += [f"## {title}", table(pd.DataFrame(rows, columns=header))]
    return [
        *parts,
        "A log ratio of 0.1 is a tenth too much or too little. The rms is over the cells of a panel; the interval is "
        f"over periods. Tables show the first {_SHOWN} readings, the CSV files all of them.",
    ]


def _times(behind: float) -> str:
    """Return how many times less likely, e.g. `1`, `37`, `10^12`."""
    times = math.exp(min(behind, math.log(_MANY)))
    if times > _MANY - 0.5:
        return f"10^{behind / math.log(10):.0f}"
    return f"{times:,.0f}" if times >= 9.95 else f"{times:.2g}"


def _fits(reading: Mapping[Any, Any], titles: Mapping[Any, str]) -> str:
    if reading["one_panel"]:
        return f"only {reading['one_panel']}"
    return "all" if reading["fits"] == len(titles) else "none"


def _distance(fitted: Mapping[Any, Any]) -> list[str]:
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
