"""The effect of one choice at each value of another."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.factorial import Factor, Factorial, Grids, Level, described
from rl_design_space.analysis.importance import PAIR, RESAMPLES, decomposed
from rl_design_space.analysis.scales import SCALES, USUAL, in_brief
from rl_design_space.analysis.statistics import percentile_interval
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import measure
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.designs import Designs, Numbers, ScaleName, chosen, given_label
from rl_design_space.report.importance import cells
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import number

#: Pairs that are drawn if none are named; lines of a panel that have a name in its legend.
_PAIRS, _LINES = 4, 8
#: Inches: height of a letter of a name below an axis, which is turned, and of such names for which there is room.
_LETTER, _TICKS = 0.05, 0.8
#: Most letters of a line of such a name.
_LONGEST = 36
_ABOUT = "_about"
#: Letters: of a legend across its axis, in a picture of its own size and in a narrow one; of the sign before a name.
_ACROSS, _HANDLE = {False: 110, True: 60}, 8


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Interactions(Report):
    """Paired differences between the values of one choice, at each value of another.

    Attributes:
        choice: such as msa; the pairs with the strongest interactions are taken if it is empty.
        other: the choice at whose values the effect is looked at.
        scale: what a period counts as, see `Importance`.
        given: values of parameters; only designs that have them count.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    choice: str = ""
    other: str = ""
    scale: ScaleName = USUAL
    given: Annotated[dict[str, Any], Field(default_factory=dict)]
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("order", "colour_map")
    own: ClassVar[Sequence[str]] = ("scale",)

    @property
    def heading(self) -> str:
        which = f"{self.choice} at each {self.other}" if self.choice else "The strongest interactions"
        return self.title or f"{which}, by {self.words.name(self.scale, in_brief(self.scale))}{given_label(self.given)}"

    def frames(self, runs: Runs) -> Frames:
        """Return a row for each pair of choices, value of one, and value of the other.

        The columns are pair, value, reference, at, difference (value − reference), low, high, interaction (that
        difference minus its mean over the values of the other choice), interaction_low, interaction_high, designs.
        Intervals are 95 %.
        """
        designs = Designs(runs, chosen(runs, self.given)).sorted()
        grids = designs.grids()
        pairs = [_named(self.choice, self.other, grids)] if self.choice else None
        numbers, _ = designs.numbers(self.scale, RESAMPLES)
        pairs = pairs or _strongest(grids, numbers)
        rows = [
            row
            for one, other in pairs
            for row in _rows(*_oriented(one, other, grids, bool(self.choice)), grids, numbers)
        ]
        about = pd.DataFrame({"note": designs.remarks()})
        return {MAIN: pd.DataFrame(rows), _ABOUT: about}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN]}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def text(self, frames: Frames) -> list[str]:
        """Return a table for each pair."""
        parts = []
        for pair, rows in frames[MAIN].groupby("pair", sort=False):
            shown = pd.DataFrame(
                {
                    "value": rows["value"],
                    "against": rows["reference"],
                    "at": rows["at"],
                    "difference": rows["difference"].map(number),
                    "95 % interval": list(map(style.interval, rows["low"], rows["high"])),
                    **(
                        {"times": np.exp(rows["difference"]).map(number)} if _is_log(self.scale) else {}
                    ),
                    "interaction": rows["interaction"].map(number),
                    "95 % interval ": list(map(style.interval, rows["interaction_low"], rows["interaction_high"])),
                }
            )  # fmt: skip
            parts += [f"## {pair}", table(shown), f"In the {rows['designs'].iloc[0]:,} designs of one factorial."]
        scale = SCALES[self.scale].meaning if self.scale in SCALES else f"{self.scale}, {measure(self.scale).meaning}"
        return [
            *parts,
            f"*Difference*: of {scale}, value minus the one it is compared against, mean over all other choices. "
            "*Interaction*: how much it differs from its mean over the values of the other choice; 0 where the effect "
            "is the same everywhere. Paired by period, periods resampled in all designs alike.",
            *frames[_ABOUT]["note"],
        ]

    def numbers(self, frames: Frames) -> list[str]:
        """Return the largest interaction of each pair."""
        lines = []
        for pair, rows in frames[MAIN].groupby("pair", sort=False):
            row = max(rows.to_dict("records"), key=lambda row: abs(row["interaction"]))
            times = f", {np.exp(row['difference']):.2f} times" if _is_log(self.scale) else ""
            lines.append(
                f"{pair}: {row['value']} against {row['reference']} at {row['at']}: {number(row['difference'])} "
                f"({style.interval(row['low'], row['high'])}){times}; {number(row['interaction'])} "
                f"({style.interval(row['interaction_low'], row['interaction_high'])}) beyond the mean effect"
            )
        return lines


def _is_log(scale: str) -> bool:
    return scale in SCALES and SCALES[scale].is_log


def _named(choice: str, other: str, grids: Grids) -> tuple[Factor, Factor]:
    """Return the choices of these names, or whose parameters have them.

    Raises:
        ConfigError: there is no such choice, or both are the same.
    """
    found = []
    for name in (choice, other):
        which = [factor for factor in grids.factors if name == factor.name or name in factor.parameters]
        if not which:
            raise ConfigError.unknown("choice that differs between these runs", name, [f.name for f in grids.factors])
        found.append(which[0])
    if found[0] == found[1]:
        raise ConfigError(f"{choice}, {other}: these runs have no two of them apart; name two choices")
    return found[0], found[1]


def _strongest(grids: Grids, numbers: Numbers) -> list[tuple[Factor, Factor]]:
    by_name = {factor.name: factor for factor in grids.factors}
    found = [each for each in decomposed(cells(grids, numbers)).effects if PAIR in each.effect]
    if not found:
        raise ConfigError(f"{', '.join(by_name)}: no two choices differ within one factorial; {grids.gap}")
    sure = [each for each in found if each.share.low > 0][:_PAIRS] or found[:1]
    pairs = [each.effect.split(PAIR) for each in sure]
    return [(by_name[one], by_name[other]) for one, other in pairs]


def _oriented(one: Factor, other: Factor, grids: Grids, named: bool) -> tuple[Factor, Factor]:
    """Return the choice whose effect is shown first: unless named, the one with fewer values, so with fewer lines."""
    part = _part(one, other, grids)
    sizes = dict(zip(part.factors, part.points.shape, strict=True))
    return (one, other) if named or sizes[one] <= sizes[other] else (other, one)


def _part(one: Factor, other: Factor, grids: Grids) -> Factorial:
    for part in grids.parts:
        if {one, other} <= set(part.factors):
            return part
    raise ConfigError(f"{one.name}, {other.name}: do not differ within one factorial. {grids.gap}")


def _rows(one: Factor, other: Factor, grids: Grids, numbers: Numbers) -> list[dict[str, Any]]:
    part = _part(one, other, grids)
    axes = part.factors.index(one), part.factors.index(other)

    def marginal(values: FloatArray) -> FloatArray:
        """Return (…, levels of one, levels of the other) means over all other choices."""
        placed = np.moveaxis(values[..., part.points], [axis - part.points.ndim for axis in axes], (-2, -1))
        over = tuple(range(values.ndim - 1, placed.ndim - 2))
        return np.asarray(placed.mean(axis=over))

    plain, drawn = marginal(numbers.value), marginal(numbers.samples)
    differences = plain[1:] - plain[:1], drawn[:, 1:] - drawn[:, :1]
    beyond = [each - each.mean(axis=-1, keepdims=True) for each in differences]
    ends, more_ends = percentile_interval(differences[1]), percentile_interval(beyond[1])
    levels, others = part.levels[axes[0]], part.levels[axes[1]]
    names, at_names = _names(one, levels), _names(other, others)
    return [
        {
            "pair": f"{one.name}{PAIR}{other.name}",
            "value": name,
            "reference": names[0],
            "at": at,
            "difference": differences[0][row, column],
            "low": ends[0][row, column],
            "high": ends[1][row, column],
            "interaction": beyond[0][row, column],
            "interaction_low": more_ends[0][row, column],
            "interaction_high": more_ends[1][row, column],
            "designs": part.points.size,
        }
        for row, name in enumerate(names[1:])
        for column, at in enumerate(at_names)
    ]


def _names(factor: Factor, levels: Sequence[Level]) -> list[str]:
    """Return levels as on the command line, without parameters that are the same in all levels that have them."""
    values = [set(column).difference([None]) for column in zip(*levels, strict=True)]
    shorter = [
        tuple(value if len(found) > 1 else None for value, found in zip(level, values, strict=True)) for level in levels
    ]
    apart = shorter if len(set(shorter)) == len(set(levels)) else levels
    return [described(factor, level) or f"{factor.name} as usual" for level in apart]


@style.styled()
def _draw(frame: pd.DataFrame, look: Interactions) -> Figure:
    pairs = list(frame.groupby("pair", sort=False))
    columns = 1 if look.is_narrow else min(2, len(pairs))
    rows = -(-len(pairs) // columns)
    longest = max(len(line) for _, pair in pairs for tick in _ticks(pair, look)[1] for line in tick.split("\n"))
    higher = max(longest * _LETTER - _TICKS, 0)
    figure, axes = plt.subplots(
        rows, columns, figsize=(7.2 * columns, (3.6 + higher) * rows + 0.4), layout="constrained", squeeze=False
    )
    for axis, (_, pair) in zip(axes.flat, pairs, strict=False):
        _panel(axis, pair, look)
    for axis in list(axes.flat)[len(pairs) :]:
        axis.set_visible(False)
    figure.suptitle(look.heading, fontsize=11)
    return figure


def _panel(axis: Axes, pair: pd.DataFrame, look: Interactions) -> None:
    """Draw the effect of each value of one choice along the values of the other."""
    scale = look.scale
    at: Sequence[str] = list(pair["at"].unique())
    lines = list(pair.groupby("value", sort=False))
    for place, ((name, line), colour) in enumerate(zip(lines, look.colours(len(lines)), strict=True)):
        x = np.arange(len(at)) + (place - (len(lines) - 1) / 2) * min(0.12, 0.6 / len(lines))
        axis.errorbar(
            x, line["difference"], yerr=style.beyond(line["low"], line["difference"], line["high"]), color=colour,
            marker=style.MARKERS[place % len(style.MARKERS)], markersize=4, linewidth=1, capsize=2,
            label=name if len(lines) <= _LINES or place in (0, len(lines) - 1) else None,
        )  # fmt: skip
    axis.axhline(0, color="0.4", linewidth=1)
    name, ticks = _ticks(pair, look)
    turned: dict[str, Any] = {"rotation": 60, "ha": "right", "rotation_mode": "anchor"}
    axis.set_xticks(range(len(at)), ticks, **(turned if sum(map(len, ticks)) >= 70 else {}), fontsize=7.5)
    axis.set_xlabel(name)
    axis.set_ylabel(f"difference of {look.words.name(scale, in_brief(scale))}\nfrom {pair['reference'].iloc[0]}")
    if _is_log(scale):
        right = axis.secondary_yaxis("right", functions=(lambda y: y, lambda y: y))
        right.yaxis.set_major_formatter(lambda y, _: f"×{np.exp(y):.2g}")
    style.tidy(axis)
    axis.spines["right"].set_visible(_is_log(scale))
    # Above the axis, because curves of interactions cross and leave no corner empty.
    names = [str(each) for each in axis.get_legend_handles_labels()[1]]
    across = max(1, _ACROSS[look.is_narrow] // (max(map(len, names)) + _HANDLE))
    axis.legend(
        frameon=False, fontsize=7.5, loc="lower left", bbox_to_anchor=(0, 1), ncols=min(across, len(names)),
        borderaxespad=0.2,
    )  # fmt: skip


def _ticks(pair: pd.DataFrame, look: Interactions) -> tuple[str, list[str]]:
    """Return the name of the x-axis and its values, which do not repeat it: `linear k=0.03` at exploration."""
    at = list(pair["at"].unique())
    first = at[0].partition("=")[0] + "="
    if all(each.startswith(first) and " " not in each for each in at):
        return first[:-1], [look.words.value(first[:-1], each.removeprefix(first)) for each in at]
    name = str(pair["pair"].iloc[0]).rpartition(PAIR)[2]
    ticks = []
    for each in at:
        labelled = look.words(each)
        brief = re.sub(rf"(^| ){re.escape(name)}(=|\.)", r"\1", each)
        ticks.append(textwrap.fill(brief if labelled == each else labelled, _LONGEST))
    return name, ticks
