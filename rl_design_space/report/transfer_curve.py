"""How well a representation solves a new layout at once, by the number of layouts that it has learned."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts.measured import value
from rl_design_space.analysis.ratios import ratio_of
from rl_design_space.design import stages_of
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DASHES, interval, make_logarithmic, styled, tidy
from rl_design_space.tracking.selection import Where

_MEAN = "final_over_optimum"
_COLUMNS = [
    "line", "layouts", "solved", "solved_low", "solved_high", "at_once", "at_once_low", "at_once_high",
    "over_optimum", "over_optimum_median", "saved", "saved_low", "saved_high",
]  # fmt: skip
_PERCENT = ".0%"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TransferCurve(Report):
    """Zero-shot use of a new layout by the number of layouts that were learned before.

    Stages with α = 0 are zero-shot uses; the stage after each learns the same layout.

    Attributes:
        lines: points by the name of their line: their values.
        nothing: the same points with nothing carried, by the name of the line that they are the baseline of.
        at_once: within how many times the fewest steps a trial has to solve a layout at once.
        level: share of trials from which on a representation solves new layouts at once.
        grades: published grades of generalisation by the name of a line, the lowest first; none if empty.
    """

    shows: str = "Share of new layouts that are solved at once, steps over optimum, and steps saved in learning them"
    lines: Annotated[dict[str, Where], Field(min_length=1)]
    nothing: dict[str, Where] = Field(default_factory=dict)
    at_once: float = 2.0
    level: float = 0.9
    grades: dict[Text, Text] = Field(default_factory=dict)

    choosable: ClassVar[Sequence[str]] = ("colour_map",)

    def frames(self, runs: Runs) -> Frames:
        """Return line, layouts, and solved, at_once, over_optimum and saved: one row for each layout that is used.

        `saved` is 1 − the steps of learning the layout / those of learning it with nothing carried. Lines that begin
        with nothing are called `… from scratch`.
        """
        rows: list[dict[str, Any]] = []
        for line, where in self.lines.items():
            seeds = runs.seeds(where)
            scratch = runs.seeds(self.nothing[line]) if line in self.nothing else []
            rows += self._rows(runs, line, seeds, scratch)
        for line, where in self.nothing.items():
            rows += self._rows(runs, f"{line}, from scratch", runs.seeds(where), [])
        return {MAIN: pd.DataFrame(rows, columns=_COLUMNS)}

    def _rows(self, runs: Runs, line: str, seeds: Sequence[Point], scratch: Sequence[Point]) -> list[dict[str, Any]]:
        result, baseline = runs.pooled(seeds), runs.pooled(scratch) if scratch else None
        if result is None:
            return []
        rows, learned = [], 0
        for number, stage in enumerate(stages_of(seeds[0].planned.point), 1):
            if stage.point.learner.alpha:
                learned += 1
                continue
            used = {"solved": f"solved,stage={number}", "at_once": f"solved_within={self.at_once:g},stage={number}"}
            row: dict[str, Any] = {"line": line, "layouts": learned}
            for name, measure in used.items():
                found = runs.estimate(seeds, measure)
                row |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
            row["over_optimum"] = value(f"{_MEAN},stage={number}", result)
            row["over_optimum_median"] = value(f"{_MEAN},stage={number},statistic=median", result)
            if baseline:
                ratio = ratio_of(f"total_steps,stage={number + 1}", result, baseline)
                row |= {"saved": 1 - ratio.value, "saved_low": 1 - ratio.high, "saved_high": 1 - ratio.low}
            rows.append(row)
        return rows

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def numbers(self, frames: Frames) -> list[str]:
        """Return how each line uses the first and the last new layout, and from when on it solves them at once."""
        lines = []
        for name, rows in frames[MAIN].groupby("line", sort=False):
            first, last = rows.iloc[0], rows.iloc[-1]
            parts = [
                f"at once {_percent(first, 'at_once')} after {first['layouts']} layout, "
                f"{_percent(last, 'at_once')} after {last['layouts']}",
                f"solved {_percent(last, 'solved')}",
                f"median steps / optimum {last['over_optimum_median']:.2f}",
            ]
            if not math.isnan(last["saved"]):
                parts.append(f"steps saved in learning {_percent(last, 'saved')}")
            if "from scratch" not in str(name):
                parts.append(f"at once in {self.level:.0%} of trials {self._since(rows)}")
            lines.append(f"{name}: {', '.join(parts)}")
        return lines

    def text(self, frames: Frames) -> list[str]:
        """Return the numbers, whether the published grades have the measured order, and the table of all layouts."""
        rows = frames[MAIN]
        shown = [
            [
                row["line"], row["layouts"], f"{row['solved']:.1%}", f"{row['at_once']:.1%}",
                interval(row["at_once_low"], row["at_once_high"], ".1%"), f"{row['over_optimum']:.2f}",
                f"{row['over_optimum_median']:.2f}", "" if math.isnan(row["saved"]) else _percent(row, "saved"),
            ]
            for row in rows.to_dict("records")
        ]  # fmt: skip
        header = ["line", "layouts learned", "solved", "at once", "95 % interval", "steps / optimum", "median", "saved"]
        return [
            "\n".join(f"- {line}" for line in self.numbers(frames)),
            *self._graded(rows),
            f"*Solved*: zero-shot trials that reach the final goal before the step cap. *At once*: those within "
            f"{self.at_once:g} times the fewest steps possible. *Saved*: 1 − the steps of learning the layout "
            "afterwards / those with nothing carried. Intervals are bootstrap intervals over periods.",
            table(pd.DataFrame(shown, columns=header)),
        ]

    def _since(self, rows: pd.DataFrame) -> str:
        """Return after how many layouts the level is kept, and the same for both ends of the intervals."""
        value, late, early = (
            _first_kept(rows, name, self.level) for name in ("at_once", "at_once_low", "at_once_high")
        )
        most = rows["layouts"].max()
        shown = [f"≥ {most}" if each is None else str(each) for each in (value, early, late)]
        if value is None and early is None:
            return f"after {shown[0]} layouts"
        return f"after {shown[0]} layouts ({shown[1]} to {shown[2]})"

    def _graded(self, rows: pd.DataFrame) -> list[str]:
        last = {name: line.iloc[-1] for name, line in rows.groupby("line", sort=False) if name in self.grades}
        names = [name for name in self.grades if name in last]
        if len(names) < 2:
            return []
        pairs = list(pairwise(names))
        apart = [last[low]["at_once_high"] < last[high]["at_once_low"] for low, high in pairs]
        against = [last[low]["at_once_low"] > last[high]["at_once_high"] for low, high in pairs]
        order = ", ".join(f"{name} {self.grades[name]} ({_percent(last[name], 'at_once')})" for name in names)
        verdict = "contradicted" if any(against) else "not confirmed, as intervals overlap"
        if all(apart):
            verdict = "confirmed"
        return [
            f"Published grades of generalisation, and the share solved at once at the end: {order}. Order {verdict}."
        ]


def _first_kept(rows: pd.DataFrame, name: str, level: float) -> int | None:
    """Return the least number of layouts from which on a share stays at a level; None if it is not there at the end."""
    below = rows[rows[name] < level]["layouts"]
    if below.empty:
        return int(rows["layouts"].min())
    after = rows[rows["layouts"] > below.max()]["layouts"]
    return None if after.empty else int(after.min())


def _percent(row: Mapping[Any, Any] | pd.Series[Any], name: str) -> str:
    return f"{row[name]:z.0%} ({interval(row[f'{name}_low'], row[f'{name}_high'], _PERCENT)})"


@styled()
def _draw(rows: pd.DataFrame, look: TransferCurve) -> Figure:
    figure, (share, steps, saved) = plt.subplots(1, 3, figsize=(14, 4.6), layout="constrained")
    names = list(rows["line"].unique())
    dashes = DASHES * len(names)
    for name, colour, dash in zip(names, look.colours(len(names)), dashes, strict=False):
        line = rows[rows["line"] == name]
        how = {"color": colour, "linestyle": dash, "linewidth": 1.4}
        for axis, column in ((share, "at_once"), (saved, "saved")):
            if line[column].notna().any():
                low, high = line[f"{column}_low"], line[f"{column}_high"]
                axis.fill_between(line["layouts"], low, high, color=colour, alpha=0.2, linewidth=0)
                axis.plot(line["layouts"], line[column], label=name if axis is share else None, **how)
        steps.plot(line["layouts"], line["over_optimum_median"], **how)
    share.axhline(look.level, color="0.45", linewidth=0.8)
    saved.axhline(0, color="0.45", linewidth=0.8)
    make_logarithmic(steps)
    for axis, heading in (
        (share, f"solved at once: within {look.at_once:g} times the fewest steps"),
        (steps, "steps / optimum, median period"),
        (saved, "steps saved in learning the layout"),
    ):
        axis.set_title(heading, fontsize=10)
        axis.set_xlabel("layouts learned before")
        tidy(axis)
    share.set_ylim(0, 1.02)
    for axis in (share, saved):
        axis.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.suptitle(look.title, fontsize=12)
    return figure
