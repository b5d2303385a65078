"""What several stages cost together, against learning the last grid alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.ratios import plain_ratio, ratio_of
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.design import stages_of
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design, having
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DASHES, MARKERS, interval, styled, tidy
from rl_design_space.tracking.selection import Where

_SIZE, _TRIALS, _CHOICE = "world.size", "curriculum.trials", "curriculum"
#: Ratios by their column: measure, and whether learning alone explores as `usual` says.
_RATIOS = {
    "equal": ("total_steps_scaled", False),
    "equal_usual": ("total_steps_scaled", True),
    "decisions": ("total_steps", False),
    "decisions_usual": ("total_steps", True),
}
_MEDIAN = "total_steps_scaled,statistic=median"
_NOWHERE = Estimate(math.nan, math.nan, math.nan)
_COLUMNS = [
    "representation", "exploration", "grids", "trials", "carry", "steps", "coarse_share",
    *(f"{name}{end}" for name in _RATIOS for end in ("", "_low", "_high")), "median", "end", "end_alone", "pays",
]  # fmt: skip


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StageCosts(Report):
    """Steps of all stages over the steps of learning the grid of the point alone.

    Attributes:
        usual: values of the points that learn alone in the usual way, a second baseline.
        drawn: number of trials on each coarse grid in the picture; all are in the text.
    """

    shows: str = "For each representation the steps of all stages over those of learning the fine grid alone"
    usual: Annotated[Where, Field(min_length=1)]
    drawn: int = 50

    choosable: ClassVar[Sequence[str]] = ("colour_map",)

    def frames(self, runs: Runs) -> Frames:
        """Return a row for each point with stages.

        Returns:
            representation, exploration, grids (as `10 → 30`), trials (on each coarse grid), carry; steps, all of them
            in steps of the last grid's length; coarse_share, which part of these is made on coarse grids; ratios to
            learning alone in the same way, and in the usual way (`_usual`), in steps of equal length (`equal`) and in
            decisions, each with its interval; median, `equal` by medians over periods; end and end_alone, steps /
            optimum in the last ten trials; pays, whether both ratios in steps of equal length are below 1 with their
            intervals.
        """
        rows = []
        alone = [point for point in runs.points if not stages_of(point.planned.point)]
        staged = [point for point in runs.points if stages_of(point.planned.point)]
        for seeds in by_design(staged):
            same = runs.pooled(_alone(seeds[0], alone))
            usual = runs.pooled(_alone(seeds[0], having(alone, self.usual), ("representation", _SIZE)))
            rows.append(_row(seeds[0], runs.pooled(seeds), same, usual))
            for point in seeds:
                runs.forget(point)
        return {MAIN: pd.DataFrame(rows, columns=_COLUMNS)}

    def draw(self, frames: Frames) -> Figure:
        rows = frames[MAIN]
        return _draw(rows[rows["trials"] == self.drawn], self)

    def numbers(self, frames: Frames) -> list[str]:
        """Return how many points pay, and the cheapest one that is drawn of each representation and last grid."""
        known = frames[MAIN].dropna(subset="equal")
        drawn = known[known["trials"] == self.drawn]
        last = drawn["grids"].str.rpartition("→")[2]
        cheapest = drawn.loc[drawn.groupby([drawn["representation"], last], sort=False)["equal_usual"].idxmin()]
        lines = (
            f"{_name(row)}: {_ratio(row, 'equal')} of the steps alone, {_ratio(row, 'equal_usual')} of those with "
            f"the usual exploration, {_ratio(row, 'decisions')} in decisions{'; pays' if row['pays'] else ''}"
            for row in cheapest.to_dict("records")
        )
        return [f"{int(known['pays'].sum())} of {len(known)} ways to begin on coarse grids pay", *lines]

    def text(self, frames: Frames) -> list[str]:
        """Return the numbers, and all points as a table."""
        rows = frames[MAIN]
        shown = [
            [
                *(row[name] for name in ("representation", "exploration", "grids", "trials", "carry")),
                *((f"{row['steps']:,.0f}", f"{row['coarse_share']:.0%}") if not math.isnan(row["equal"]) else ("", "")),
                *(_ratio(row, name) for name in ("equal", "equal_usual", "decisions", "decisions_usual")),
                _number(row["median"]), f"{_number(row['end'])} / {_number(row['end_alone'])}",
                "yes" if row["pays"] else "no",
            ]
            for row in rows.to_dict("records")
        ]  # fmt: skip
        header = [
            "representation", "exploration", "grids", "trials", "carry", "steps", "coarse", "equal length / alone",
            "/ alone, usual", "decisions / alone", "/ alone, usual", "medians", "end, alone", "pays",
        ]  # fmt: skip
        return [
            "\n".join(f"- {line}" for line in self.numbers(frames)),
            "Steps are those of all stages, coarse grids included, to the end of the same trials on the fine grid. In "
            "*steps of equal length* a step on a d×d grid counts as D/d steps on D×D; in *decisions* each step counts "
            "as one. *Alone* explores in the same way as the first grid; *usual* with "
            f"{' '.join(f'{name}={value}' for name, value in self.usual.items())}. Steps: in the length of the last "
            "grid. *End*: steps / optimum in the last ten trials. It pays if both ratios in steps of equal length are "
            "below 1 with their 95 % intervals (bootstrap over periods, paired by layout).",
            table(pd.DataFrame(shown, columns=header)),
        ]


def _alone(point: Point, among: Sequence[Point], names: Sequence[str] | None = None) -> list[Point]:
    """Return the points of the one design that learns the grid of a point alone; none if there are none or several."""
    keys = [key for key in point.parameters if key.partition(".")[0] not in (_CHOICE, "seed")]
    where = {name: point.parameters[name] for name in (names or keys)}
    designs = by_design(having(among, where))
    return designs[0] if len(designs) == 1 else []


def _row(
    point: Point, result: LearningCurves | None, same: LearningCurves | None, usual: LearningCurves | None
) -> dict[str, Any]:
    grids = [stage.point.world.shape[0] for stage in stages_of(point.planned.point)]
    row: dict[str, Any] = {
        "representation": _words(point.parameters["representation"]),
        "exploration": point.parameters["exploration"],
        "grids": " → ".join(map(str, grids)),
        "trials": point.parameters[_TRIALS],
        "carry": _words(point.parameters["curriculum.carry"]),
        "steps": math.nan, "coarse_share": math.nan, "median": math.nan,
        "end": math.nan, "end_alone": math.nan, "pays": False,
    }  # fmt: skip
    for name, (measure, is_usual) in _RATIOS.items():
        other = usual if is_usual else same
        found = ratio_of(measure, result, other) if result and other else _NOWHERE
        row |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
    if result and same:
        row["median"] = plain_ratio(_MEDIAN, result, same)
    if result:
        scaled = [result.stage(number).scaled_steps.mean() for number in range(1, len(grids) + 1)]
        last = result.stage(len(grids))
        row |= {
            "steps": sum(scaled) * grids[-1] / 10, "coarse_share": sum(scaled[:-1]) / sum(scaled), "end": _end(last),
            "end_alone": _end(same) if same else math.nan,
            "pays": max(row["equal_high"], row["equal_usual_high"]) < 1,
        }  # fmt: skip
    return row


def _end(result: LearningCurves) -> float:
    return result.scalars()["final_steps_over_optimum"]


def _words(value: Any) -> str:
    return str(value).replace("_", " ")


def _name(row: Mapping[Any, Any]) -> str:
    return f"{row['representation']}, {row['exploration']}, {row['grids']}, {row['carry']}"


def _number(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.2f}"


def _ratio(row: Mapping[Any, Any], name: str) -> str:
    return f"{row[name]:.2f} ({interval(row[f'{name}_low'], row[f'{name}_high'], '.2f')})"


@styled()
def _draw(rows: pd.DataFrame, look: StageCosts) -> Figure:
    representations, names = list(rows["representation"].unique()), ["grids", "exploration", "carry"]
    ways = rows.sort_values(names, kind="stable", key=lambda column: column.map(str))[names].drop_duplicates()
    places = {tuple(way): place for place, way in enumerate(reversed(ways.values.tolist()))}
    figure, axes = plt.subplots(
        1, max(1, len(representations)), layout="constrained", squeeze=False, sharex=True, sharey=True,
        figsize=(3.6 * max(1, len(representations)) + 2.4, 0.32 * len(places) + 2),
    )  # fmt: skip
    kinds = [
        ("equal", "steps of equal length / alone, explored in the same way", 0.12),
        ("equal_usual", "steps of equal length / alone, ε = 0.1", 0.0),
        ("decisions", "decisions / alone, explored in the same way", -0.12),
    ]
    for axis, representation in zip(axes[0], representations, strict=False):
        here = rows[rows["representation"] == representation]
        y = [places[tuple(way)] for way in here[names].values.tolist()]
        for (kind, what, above), colour, marker in zip(kinds, look.colours(len(kinds)), MARKERS, strict=False):
            reach = [here[kind] - here[f"{kind}_low"], here[f"{kind}_high"] - here[kind]]
            axis.errorbar(
                here[kind], [place + above for place in y], xerr=reach, fmt=marker, color=colour, markersize=4,
                linewidth=1, label=what if axis is axes[0][0] else None,
            )  # fmt: skip
        axis.axvline(1, color="0.45", linewidth=1, linestyle=DASHES[1])
        axis.set_xscale("log")
        axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_title(representation, fontsize=10)
        axis.set_xlabel("steps of all stages / steps alone")
        axis.set_yticks(list(places.values()), [", ".join(map(_words, way)) for way in places])
        tidy(axis)
    if len(rows):
        figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    figure.suptitle(look.title, fontsize=12)
    return figure
