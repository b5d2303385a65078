"""In how many layouts a design is how near the optimum, and how often it beats another one."""

from __future__ import annotations

from collections.abc import Sequence
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
from rl_design_space.analysis.profiles import improvement, profile
from rl_design_space.analysis.scales import SCALES
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.cells import colour_cells, write
from rl_design_space.report.designs import Designs, chosen, given_label
from rl_design_space.report.fitting import break_headings
from rl_design_space.report.many import apart
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import label
from rl_design_space.report.runs import Runs

#: Levels of steps / optimum at which shares are computed; levels of the table in the text.
_LEVELS, _LISTED = 120, (1.5, 2, 3, 5, 10)
IMPROVEMENT = "_improvement"
#: Inches: height of the picture without its legend, and of a line of that.
_HEIGHT, _LINE = 4.3, 0.165
#: Inches: width of the curves; height of what is above and below the matrix, and width beside it; most that a cell has,
#: least of a matrix, and least of a cell for its interval to be written.
_CURVES, _AROUND, _BESIDE, _CELL, _MATRIX, _INTERVAL = 7.5, 1.1, 0.5, 0.6, 3.6, 0.46
#: Height of a row that has none, over that of the other; it has to be above 0.
_NO_HEIGHT = 1e-6
_ABOUT = "_about"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Profile(Report):
    """Performance profiles, and the probability of improvement between designs, over layouts.

    Attributes:
        designs: number of designs that are drawn, those with the least mean of log(steps / optimum).
        given: values of parameters; only designs that have them count.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    designs: Annotated[int, Field(ge=1, le=20)] = 8
    given: Annotated[dict[str, Any], Field(default_factory=dict)]
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("scale", "colour_map")

    @property
    def heading(self) -> str:
        return self.title or f"Performance profiles{given_label(self.given)}"

    def frames(self, runs: Runs) -> Frames:
        """Return design, steps_over_optimum, share, low, high: the share of periods up to each steps / optimum.

        `_improvement` has a, b, probability, low, high: of a needing fewer steps than b in the same layout.
        """
        found = Designs(runs, chosen(runs, self.given)).sorted()
        scale = SCALES["over_optimum"]
        scores = np.stack([scale.each(result) for result in found.results()], axis=1)
        best = np.argsort(np.log(scores).mean(axis=0), kind="stable")[: self.designs]
        names = {
            place: label(
                [name for name in found.names if found.parameters[place].get(name) is not None],
                (each for name in found.names if (each := found.parameters[place].get(name)) is not None),
            )
            or "the design"
            for place in best.tolist()
        }
        last = max(float(np.quantile(scores[:, best], 0.99)), 1.5)
        levels = np.unique(np.concatenate([np.geomspace(1, last, _LEVELS), [each for each in _LISTED if each < last]]))
        rows = []
        for place, name in names.items():
            shares = profile(scores[:, place], levels)
            rows += [
                {"design": name, "steps_over_optimum": level, "share": share, "low": low, "high": high}
                for level, share, low, high in zip(levels, *shares, strict=True)
            ]
        pairs = [
            {"a": names[a], "b": names[b], **_probability(improvement(scores[:, a], scores[:, b]))}
            for a in names
            for b in names
            if a != b
        ]
        hidden = f" The best {len(names)} of them are shown." if len(names) < len(found) else ""
        about = pd.DataFrame({"note": [" ".join(found.remarks()) + hidden]})
        return {
            MAIN: pd.DataFrame(rows),
            IMPROVEMENT: pd.DataFrame(pairs, columns=["a", "b", "probability", "low", "high"]),
            _ABOUT: about,
        }

    def csv(self, frames: Frames) -> Frames:
        return {name: frame for name, frame in frames.items() if name != _ABOUT}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], frames[IMPROVEMENT], self)

    def text(self, frames: Frames) -> list[str]:
        """Return shares at a few levels, and how often the first design beats the others."""
        rows = frames[MAIN]
        levels = [level for level in _LISTED if level in rows["steps_over_optimum"].to_numpy()]
        shares = []
        for name, line in rows.groupby("design", sort=False):
            at = line.set_index("steps_over_optimum")
            cells_ = [f"{at['share'][n]:.0%} ({at['low'][n]:.0%} – {at['high'][n]:.0%})" for n in levels]
            shares.append((name, *cells_))
        first = frames[IMPROVEMENT][frames[IMPROVEMENT]["a"] == rows["design"].iloc[0]]
        against = pd.DataFrame(
            {
                "beats": first["b"],
                "with probability": first["probability"].map("{:.2f}".format),
                "95 % interval": [
                    style.interval(low, high) for low, high in zip(first["low"], first["high"], strict=True)
                ],
            }
        )
        return [
            "Share of layouts in which all trials together take at most so many times the optimum:",
            table(pd.DataFrame(shares, columns=["design", *(f"≤ {level:g}" for level in levels)])),
            *([f"{rows['design'].iloc[0]}:", table(against)] if len(against) else []),
            "After Agarwal et al. (NeurIPS 2021), with the periods as tasks: every period has a layout of its own, "
            "which all designs meet. The probability of improvement is the share of layouts in which a design needs "
            "fewer steps than the other, a tie counting half. Intervals: 95 %, periods resampled, at each level by "
            "itself.",
            *frames[_ABOUT]["note"],
        ]

    def numbers(self, frames: Frames) -> list[str]:
        """Return how near the optimum half of the layouts are, and how often the first design beats the others."""
        rows = frames[MAIN]
        lines = []
        for name, line in list(rows.groupby("design", sort=False))[:5]:
            half = line[line["share"] >= 0.5]["steps_over_optimum"].min()
            lines.append(f"{name}: half of the layouts within {half:.2f} times the optimum")
        first = frames[IMPROVEMENT][frames[IMPROVEMENT]["a"] == rows["design"].iloc[0]].head(4)
        for row in first.to_dict("records"):
            low_high = style.interval(row["low"], row["high"])
            lines.append(f"{row['a']} beats {row['b']} in {row['probability']:.0%} of layouts ({low_high})")
        return lines


def _probability(estimate: Any) -> dict[str, float]:
    return {"probability": estimate.value, "low": estimate.low, "high": estimate.high}


@style.styled()
def _draw(rows: pd.DataFrame, pairs: pd.DataFrame, look: Profile) -> Figure:
    lines = list(rows.groupby("design", sort=False))
    both = len(pairs) > 0
    labels, common = apart([str(name) for name, _ in lines])
    legend = sum(name.count("\n") + 1 for name in labels) + 2 * bool(common)
    height = _HEIGHT + _LINE * legend
    side = min(height - _AROUND, max(_CELL * len(lines), _MATRIX))
    if both and look.is_narrow:
        size = _CURVES, height + 4.5
        figure, found = plt.subplots(2, 1, figsize=size, layout="constrained", height_ratios=(1.2, 1))
        axes = list(found)
    elif both:
        figure = plt.figure(figsize=(_CURVES + side + _BESIDE, height), layout="constrained")
        # Curves have the first row, with their legend below; the matrix is beside both.
        grid = figure.add_gridspec(2, 2, width_ratios=(_CURVES, side + _BESIDE), height_ratios=(1, _NO_HEIGHT))
        axes = [figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[:, 1], anchor="N")]
    else:
        figure, found = plt.subplots(figsize=(_CURVES, height), layout="constrained")
        axes = [found]
    axis = axes[0]
    for place, (name, (_, line), colour) in enumerate(zip(labels, lines, look.colours(len(lines)), strict=True)):
        x = line["steps_over_optimum"]
        axis.fill_between(x, line["low"], line["high"], color=colour, alpha=0.2, linewidth=0)
        dashes = style.DASHES[place % len(style.DASHES)]
        axis.plot(x, line["share"], color=colour, linestyle=dashes, linewidth=1.4, label=f"{place + 1}  {name}")
    if look.is_log(rows["steps_over_optimum"], by_itself=True):
        axis.set_xscale("log")
    last = float(rows["steps_over_optimum"].max())
    ticks = [each for each in (1, 1.5, 2, 3, 5, 10, 20, 50, 100, 200, 500) if each <= last]
    axis.set_xticks(ticks, [f"{each:g}" for each in ticks])
    axis.minorticks_off()
    axis.set_ylim(0, 1)
    axis.yaxis.set_major_formatter(lambda share, _: f"{share:.0%}")
    axis.set_xlabel("τ: steps of all trials, in multiples of the optimum")
    axis.set_ylabel("share of layouts with at most τ")
    style.tidy(axis)
    axis.legend(frameon=False, fontsize=7.5, loc="upper center", bbox_to_anchor=(0.5, -0.13))
    if both:
        _matrix(axes[1], pairs, [name for name, _ in lines], look.cells_map, intervals=side / len(lines) >= _INTERVAL)
    figure.suptitle(look.heading, fontsize=11)
    if common:
        figure.supxlabel(common, fontsize=7.5)
        break_headings(figure)
    return figure


def _matrix(axis: Axes, pairs: pd.DataFrame, names: list[Any], colour_map: str, *, intervals: bool) -> None:
    """Draw the probability of improvement of each design over each other, with or without its interval."""
    values = pairs.pivot_table(index="a", columns="b", values="probability", sort=False).reindex(
        index=names, columns=names
    )
    numbers = [str(place) for place in range(1, len(names) + 1)]
    numbered = values.set_axis(numbers).set_axis(numbers, axis=1)
    inks = colour_cells(axis, numbered, Normalize(0, 1), square=True, colour_map=colour_map)
    for row in pairs.to_dict("records"):
        y, x = names.index(row["a"]), names.index(row["b"])
        between = f"{row['low']:.2f}–{row['high']:.2f}" if intervals else ""
        number = (0.4 if between else 0.5, f"{row['probability']:.2f}", {"fontsize": 9})
        write(axis, x, y, [number, (0.72, between, {"fontsize": 6})], inks[y][x])
    axis.set_title(
        "probability that the row's design needs fewer steps\nthan the column's in the same layout", fontsize=9
    )
    axis.set_xlabel("")
    axis.set_ylabel("")
