"""Two choices side by side, everything else equal: how much more one needs than the other, period by period."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.differences import differing
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.bounds import notes, shown, shown_interval, without_exact
from rl_design_space.report.fitting import make_room
from rl_design_space.report.look import LINEAR, RATIO
from rl_design_space.report.many import HALF, MOST, Named, Top, apart, named, without_effect
from rl_design_space.report.markdown import table
from rl_design_space.report.pairs import OF_RATIO, Pair, ratio_of, row_of
from rl_design_space.report.parameters import SEED, check_averaged, label
from rl_design_space.report.points import Point, repetition
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DARK_BLUE, beyond, interval, show_ratios, styled, tidy
from rl_design_space.report.written import MainNumbers
from rl_design_space.tracking.run_frame import typed

#: Name of the row of all pairs together.
_ALL = "all pairs"
#: Height of a row and longest side of the picture, in inches.
_HEIGHT, _LONGEST = 0.36, 40

#: Columns of what is drawn.
_OF_DIFFERENCE = "difference", "low", "high"
_RATIOS = (
    "Ratio: of the means; of all pairs, the geometric mean. Its interval is that of the linear part of its logarithm."
)
_PAIRED = (
    "Paired by period of each seed: both sides met the same starts and goals, unless seed, world or number of goals is "
    "what is compared."
)
#: Parameters by name in which both sides of a pair are equal.
_Rest = tuple[tuple[str, Any], ...]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Compare(Report):
    """Differences of pairs of points that are equal in everything but what is compared.

    Points of equal seed and size meet the same starts and goals, so each period of one is compared with the same
    period of the other: which layouts were drawn does not matter.

    Of more than `top` pairs, the largest effects are shown, and where most pairs lie. Effects of many pairs are ratios,
    because a difference is as large as the numbers of its pair; `scale` chooses.

    Attributes:
        a: values of parameters, as on the command line: `representation=ad_hoc`; several with spaces between.
        b: values of the same parameters on the other side.
        value: measure that is compared, see docs/reports.md.
        mean: whether runs of one side that differ in what is compared are averaged, period by period.
        named: pairs that are shown in any case, by values that they have.
        top: number of pairs that picture and text show, the largest effects first; all are in the CSV file.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    a: str
    b: str
    value: MeasureName = "total_steps"
    mean: bool = False
    named: Named = ()
    top: Top = 20
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("order", "scale")
    scales: ClassVar[Sequence[str]] = (LINEAR, RATIO)

    @property
    def heading(self) -> str:
        return self.title or f"{self.value}: {self.b} minus {self.a}"

    def frames(self, runs: Runs) -> Frames:
        """Return pair, a, b, difference (b − a), low, high (95 %, paired), periods: one row a pair, all pairs last.

        Where ratios are shown, ratio, ratio_low and ratio_high are those of the means, b / a, see `pairs.ratio_of`.
        """
        sides = [_wanted(side) for side in (self.a, self.b)]
        if sides[0] == sides[1]:
            raise ConfigError(f"{self.a}, {self.b}: both sides are the same; name two that differ")
        compared = {name for side in sides for name in side}
        runs.check(compared)
        for side in sides:
            runs.check_values(side)
        ours, theirs = (self._by_rest(runs, side, compared) for side in sides)
        common = [rest for rest in ours if rest in theirs]
        if not common:
            found = [sum(map(len, side.values())) for side in (ours, theirs)]
            raise ConfigError(
                f"{self.a}, {self.b}: no two runs are equal in everything else ({found[0]} and {found[1]} runs)"
            )
        others = differing([dict(rest) for rest in common], beside=compared)
        pairs: dict[tuple[Any, ...], list[Pair]] = {}
        for rest in sorted(common, key=lambda rest: [runs.ordering.key(name, dict(rest).get(name)) for name in others]):
            key = tuple(dict(rest).get(name) for name in others if name != SEED)
            pairs.setdefault(key, []).append(self._pair(runs, ours[rest], theirs[rest], dict(rest)))
        names, measured = [name for name in others if name != SEED], measure(self.value)
        for key, seeds in pairs.items():
            if len({pair.repetition.design for pair in seeds}) > 1:
                where = f" of {label(names, key)}" if names else ""
                raise ConfigError(f"{SEED}: not all runs{where} that are averaged have the same seeds; use --where")
        shown_pairs = {label(names, key) or "the pair": seeds for key, seeds in pairs.items()}
        if len(pairs) > 1:
            shown_pairs[_ALL] = [pair for seeds in pairs.values() for pair in seeds]
        rows = [{"pair": name, **row_of(measured, seeds)} for name, seeds in shown_pairs.items()]
        if self.scale == RATIO or (not self.scale and len(pairs) > self.top):
            rows = [
                {**row, **ratio_of(measured, seeds)} for row, seeds in zip(rows, shown_pairs.values(), strict=True)
            ]  # fmt: skip
        return {MAIN: without_exact(pd.DataFrame(rows))}

    def _by_rest(self, runs: Runs, side: Mapping[str, Any], compared: set[str]) -> dict[_Rest, list[Point]]:
        """Return the runs of a side by everything in which those of a pair are equal.

        Raises:
            ConfigError: several runs of the side are equal in that, and their mean is not asked for.
        """
        found: dict[_Rest, list[Point]] = {}
        for point in runs.recorded:
            if point.has(side):
                found.setdefault(_rest(point, compared), []).append(point)
        name = label(side, side.values())
        for points in found.values():
            advice = f"name its value beside {name}"
            check_averaged([point.choices for point in points], f"side ({name})", advice, self.mean)
        return found

    def _pair(self, runs: Runs, ours: Sequence[Point], theirs: Sequence[Point], rest: Mapping[str, Any]) -> Pair:
        before, after = (self._results(runs, points) for points in (ours, theirs))
        common = min(len(each.steps) for each in (*before, *after))
        before, after = ([each.first(common) for each in side] for side in (before, after))
        designs = tuple(repetition(point).design for point in (*ours, *theirs))
        return Pair(before, after, Repetition(designs, rest.get(SEED)))

    def _results(self, runs: Runs, points: Sequence[Point]) -> list[LearningCurves]:
        """Return the results of the points of one side."""
        results = [result for point in points if (result := runs.kept(point))]
        if len(results) < len(points):
            raise ConfigError(f"{self.value}: is not known period by period for {_described(points[0])}")
        return results

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def heading_of(self, frames: Frames) -> str:
        heading = self.heading
        return heading.replace(" minus ", " over ") if not self.title and _has_ratios(frames[MAIN]) else heading

    def text(self, frames: Frames) -> list[str]:
        """Return one row for each pair, or for those with the largest effects."""
        pairs = self.shown_pairs(frames[MAIN])
        rows = pairs.to_dict("records")
        ratios = {
            "ratio": pairs["ratio"].map(lambda ratio: "–" if np.isnan(ratio) else f"{ratio:.3g}"),
            "95 % interval ": list(map(interval, pairs["ratio_low"], pairs["ratio_high"])),
        } if "ratio" in pairs else {}  # fmt: skip
        texts = pd.DataFrame(
            {
                "pair": pairs["pair"],
                self.a: [shown(pair, "a") for pair in rows],
                self.b: [shown(pair, "b") for pair in rows],
                "difference": [shown(pair, "difference") for pair in rows],
                "95 % interval": list(map(shown_interval, rows)),
                **ratios,
                "periods": pairs["periods"],
            }
        )
        more = [f"{len(pairs) - 1} of {len(frames[MAIN]) - 1} pairs; the CSV file has the others."]
        return [
            *(more if len(pairs) < len(frames[MAIN]) else []),
            table(texts),
            _PAIRED,
            *([_RATIOS] if ratios else []),
            *notes(pairs),
        ]

    def main_numbers(self, frames: Frames) -> MainNumbers:
        """Return the table of the pairs, below a note if it has all of them in any case."""
        pairs = int((frames[MAIN]["pair"] != _ALL).sum())
        return replace(super().main_numbers(frames), lines=tuple(without_effect(self.named, pairs, self.top, "pair")))

    def shown_pairs(self, pairs: pd.DataFrame) -> pd.DataFrame:
        """Return the pairs that picture and text show: all, or the largest effects and those that are named.

        Raises:
            ConfigError: there are no such pairs as were named.
        """
        single = pairs[pairs["pair"] != _ALL]
        wanted = named(single["pair"], self.named)
        if len(single) <= self.top:
            return pairs
        size = _effects(single).abs().fillna(0)
        largest = single.loc[size.sort_values(ascending=False, kind="stable").index]
        is_named = largest["pair"].isin(wanted)
        most = pd.concat([largest[is_named], largest[~is_named].head(max(0, self.top - len(wanted)))])
        return pd.concat([most.loc[_effects(most).sort_values(kind="stable").index], pairs[pairs["pair"] == _ALL]])


def _effects(pairs: pd.DataFrame) -> pd.Series[float]:
    """Return the logarithm of the ratio of each pair, or its difference if a ratio is not known."""
    return np.log(pairs["ratio"]) if _has_ratios(pairs) else pairs["difference"]


def _has_ratios(pairs: pd.DataFrame) -> bool:
    return "ratio" in pairs and bool(pairs["ratio"].notna().all())


@styled()
def _draw(every: pd.DataFrame, look: Compare) -> Figure:
    frame = look.shown_pairs(every)
    height = min(_HEIGHT * len(frame) + 1.6, _LONGEST)
    figure, axis = plt.subplots(figsize=(7.5, height), layout="constrained")
    y = np.arange(len(frame))[::-1]
    ratios = _has_ratios(every)
    value, low, high = (frame[name] for name in (OF_RATIO if ratios else _OF_DIFFERENCE))
    none = 1 if ratios else 0
    reach = beyond(low, value, high)
    clear = (low > none) | (high < none)
    for which, face in ((clear, DARK_BLUE), (~clear, "white")):
        axis.errorbar(
            value[which], y[which], xerr=reach[:, which], fmt="o",
            color=DARK_BLUE, markerfacecolor=face, markersize=5, linewidth=1.2,
        )  # fmt: skip
    axis.axvline(none, color="0.4", linewidth=1)
    names, common = apart(frame["pair"].tolist())
    axis.set_yticks(y, names)
    axis.set_ylim(-0.6, len(frame) - 0.4)
    axis.xaxis.set_major_formatter(lambda number_, _: f"{number_:,g}")
    what = f"{look.value}: {look.b} over {look.a}" if ratios else f"difference of {look.value}"
    axis.set_xlabel(f"{what} with its 95 % interval; hollow: the interval contains {none}")
    if ratios:
        show_ratios(axis.xaxis, float(low.min()), float(high.max()))
    if len(frame) < len(every):
        _draw_range(axis, every[every["pair"] != _ALL]["ratio" if ratios else "difference"])
    axis.set_title(look.heading_of({MAIN: every}), fontsize=11)
    tidy(axis)
    if common:
        figure.supxlabel(common, fontsize=7.5)
    if len(frame) < len(every) or common:
        make_room(figure)
    return figure


def _draw_range(axis: Axes, effects: pd.Series[float]) -> None:
    """Draw where most of all pairs lie behind those that are shown."""
    for (low, high), colour, name in (
        (MOST, "0.94", f"80 % of all {len(effects)} pairs"),
        (HALF, "0.86", "half of them"),
    ):
        axis.axvspan(*effects.quantile([low, high]), color=colour, linewidth=0, zorder=0, label=name)
    axis.axvline(float(effects.median()), color="0.5", linestyle="--", linewidth=1, zorder=0.5, label="their median")
    # Below the axis, where `make_room` puts it: names take the room beside it.
    axis.legend(frameon=False, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.1))


def _wanted(side: str) -> dict[str, Any]:
    """Return `representation=ad_hoc exploration.k=0.02` as values by name.

    Raises:
        ConfigError: a part has no equals sign.
    """
    wanted = {}
    for part in side.split():
        name, equals, value = part.partition("=")
        if not equals:
            raise ConfigError(f"{side}: should be values of parameters, such as representation=ad_hoc")
        wanted[name] = typed(value)
    return wanted


def _rest(point: Point, compared: set[str]) -> _Rest:
    """Return everything in which both points of a pair are equal: all but what is compared and its values."""
    prefixes = tuple(f"{name}." for name in compared)
    known = {**point.choices, SEED: point.parameters.get(SEED)}
    rest = {name: value for name, value in known.items() if name not in compared}
    return tuple(sorted((name, value) for name, value in rest.items() if not name.startswith(prefixes)))


def _described(point: Point) -> str:
    return point.run.run_id if point.run else "a point without a run"
