"""Stages of periods in pictures of learning curves: where they begin, and the baselines of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from rl_design_space.analysis.learning_curves import random_walk_steps
from rl_design_space.design import stages_of
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.stage_layouts import stage_layouts
from rl_design_space.learning.stage_record import STAGE_CURVE, bounds
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs

#: Name of the frame, and of the lines in a picture.
STAGES = "stages"
#: Levels, how they are drawn, and their colour.
LEVELS, GREY = (("optimum", "--"), ("random_walk", ":")), "0.45"
STAGE_NOTE = "\nA vertical line: a stage begins, with another world, layout, representation or learner."
_COLUMNS = ["panel", "begin", "end", "optimum", "random_walk"]


def stage_frame(
    points: Mapping[tuple[str, str], Sequence[Point]], results: Mapping[tuple[str, str], LearningCurves | None]
) -> pd.DataFrame:
    """Return the stages of each panel, those of the line that has the most; none of panels without stages.

    Args:
        points: points of one design for each line, by panel and line.
        results: their results.

    Returns:
        panel; begin and end, trials; optimum and random_walk, steps of a trial.
    """
    rows: dict[str, list[dict[str, object]]] = {}
    for (panel, line), result in results.items():
        if result and len(result.stages) > len(rows.get(panel, ())):
            rows[panel] = [{"panel": panel, **level} for level in stage_levels(points[panel, line], result)]
    return pd.DataFrame([row for of_panel in rows.values() for row in of_panel], columns=_COLUMNS)


def stage_levels(seeds: Sequence[Point], result: LearningCurves) -> list[dict[str, float]]:
    """Return the steps of a trial of the best policy, and of a random walk, on the layouts of each stage.

    Returns:
        begin and end, trials; optimum and random_walk, steps: one for each stage; none if periods have one stage.
    """
    of_seeds = [(stages_of(each.planned.point), each.planned.point) for each in seeds]
    layouts = [stage_layouts(point, stages) for stages, point in of_seeds]
    return [
        {
            "begin": trials.start,
            "end": trials.stop,
            "optimum": float(record.optimum.mean()),
            "random_walk": random_walk_steps(stage.point.world, np.concatenate(each)),
        }
        for stage, record, trials, *each in zip(
            stages_of(result.point), result.stages, bounds(result.stages), *layouts, strict=True
        )
    ]


def begins_of(runs: Runs, point: Point) -> list[int]:
    """Return the trials with which the stages of a recorded point begin, but the first; none if it has one stage."""
    try:
        stages = runs.curve(point, STAGE_CURVE)
    except ConfigError:
        return []
    found: list[int] = (1 + np.flatnonzero(np.diff(stages))).tolist()
    return found


def draw_stages(above: Axes, below: Axes, stages: pd.DataFrame) -> None:
    """Draw the optimum and a random walk of each stage, and a line where a stage begins."""
    for stage in stages.to_dict("records"):
        for level, dashes in LEVELS:
            above.hlines(stage[level], stage["begin"], stage["end"] - 1, color=GREY, linestyle=dashes, linewidth=1)
        if stage["begin"]:
            for axis in (above, below):
                axis.axvline(stage["begin"] - 0.5, color=GREY, linewidth=0.8, alpha=0.6, gid=STAGES)
