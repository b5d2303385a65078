"""Learning from scratch beside stages: the same stages, each of which begins with nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from rl_design_space.analysis.ratios import ratio_of
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs
from rl_design_space.report.stage_marks import GREY
from rl_design_space.report.style import interval

#: Name of the frame.
SCRATCH = "_scratch"
SCRATCH_NOTE = " Thin grey: from scratch, the same stages with nothing carried."
_COLUMNS = ["panel", "line", "trial", "mean", "ratio", "low", "high"]

_Lines = Mapping[tuple[str, str], Sequence[Point]]
_Results = Mapping[tuple[str, str], LearningCurves | None]


def scratch_frame(runs: Runs, points: _Lines, results: _Results) -> pd.DataFrame:
    """Return the curves of learning the stages of each line from scratch; none where that is not recorded.

    Args:
        runs: the runs.
        points: points of one design for each line, by panel and line.
        results: their results.

    Returns:
        panel, line, trial; mean, steps from scratch; ratio, low and high, total steps of the line over those from
        scratch with the 95 % interval, the same in all trials.
    """
    parts = []
    for (panel, line), result in results.items():
        scratch = runs.from_scratch(points[panel, line]) if result and result.stages else None
        # A line that carries nothing is its own baseline.
        if result is None or scratch is None or (scratch.steps == result.steps).all():
            continue
        is_paired = len(scratch.steps) == len(result.steps)
        ratio = ratio_of("total_steps", result, scratch) if is_paired else Estimate(math.nan, math.nan, math.nan)
        curve = pd.DataFrame({"mean": scratch.curves["steps/mean"]}).rename_axis("trial").reset_index()
        known = {"ratio": ratio.value, "low": ratio.low, "high": ratio.high}
        parts.append(curve.assign(panel=panel, line=line, **known)[_COLUMNS])
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=_COLUMNS)


def draw_scratch(axis: Axes, scratch: pd.DataFrame) -> list[Line2D]:
    """Draw the curves of a panel, each once; return what the legend shows."""
    drawn: list[tuple[float, ...]] = []
    for _, curve in scratch.groupby("line", sort=False):
        if (steps := tuple(curve["mean"])) not in drawn:
            drawn.append(steps)
            axis.plot(curve["trial"], curve["mean"], color=GREY, linewidth=0.9, zorder=1, gid=SCRATCH)
    return [Line2D([], [], color=GREY, linewidth=0.9, label="from scratch")] if drawn else []


def told_of_scratch(scratch: pd.DataFrame, has_stages: bool) -> list[str]:
    """Return how many steps each line needs of those from scratch, or how to record these."""
    if scratch.empty:
        how = "the same point with `curriculum.carry=none`, or with `carry: none` in each of its stages, records it."
        return [f"Learning the stages from scratch is not recorded; {how}"] if has_stages else []
    rows = scratch.drop_duplicates(["panel", "line"]).dropna(subset="ratio").to_dict("records")
    needs = (
        f"{row['line']} ({row['panel']}) {row['ratio']:.2f} ({interval(row['low'], row['high'], '.2f')})"
        for row in rows
    )
    return [f"Total steps over those of learning the same stages from scratch: {'; '.join(needs)}."]
