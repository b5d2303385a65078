"""Baselines of learning curves: the optimum, the best memoryless policy, and a random walk."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pandas as pd

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.learning_curves import random_walk_steps
from rl_design_space.design import DesignPoint, MultiStepActions, stages_of
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.points import Point

#: Ratio to the optimum from which on the best memoryless policy is a baseline of its own.
MORE = 1.001
#: Levels of a panel of which nothing is recorded.
NO_LEVELS: Mapping[str, float] = MappingProxyType({"optimum": math.nan, "random_walk": math.nan})


def line_baselines(
    points: Mapping[tuple[str, str], Sequence[Point]], results: Mapping[tuple[str, str], LearningCurves | None]
) -> tuple[dict[tuple[str, str], float], dict[str, Mapping[str, float]]]:
    """Return the baselines of recorded lines, in steps of a trial.

    Args:
        points: of each line, by the names of its panel and its own.
        results: of each line; None if it is not recorded.

    Returns:
        The best memoryless policy of each line, NaN if it is not known; and by panel the best policy (`optimum`) and
        the random walk (`random_walk`) on the layouts of its first line.
    """
    known: dict[str, FloatArray] = {}
    recorded = {names: result for names, result in results.items() if result}
    memoryless = {names: _memoryless_level(points[names], known) for names in recorded}
    panels: dict[str, Mapping[str, float]] = {}
    for names, result in recorded.items():
        if names[0] not in panels:
            panels[names[0]] = _levels(points[names], result)
    return memoryless, panels


def _levels(seeds: Sequence[Point], result: LearningCurves) -> Mapping[str, float]:
    layouts = np.concatenate([layouts_of(point.planned.point) for point in seeds])
    walk = random_walk_steps(result.point.world, layouts)
    return {"optimum": float(result.optimum.mean()), "random_walk": walk}


def _memoryless_level(seeds: Sequence[Point], known: dict[str, FloatArray]) -> float:
    """Return the steps of a trial of the best memoryless policy, mean over layouts; NaN if it is not known.

    Args:
        seeds: points of one design.
        known: earlier results by layout, to which these are added; most lines share their layouts and observations.
    """
    points = [point.planned.point for point in seeds]
    if any(map(stages_of, points)):
        return float("nan")
    return float(np.mean(np.concatenate([_memoryless_steps(each, known) for each in points])))


def _memoryless_steps(point: DesignPoint, known: dict[str, FloatArray]) -> FloatArray:
    """Return the steps of the best memoryless policy, (layouts,): the primitive actions alone are searched first."""
    from rl_design_space.learning.memoryless import memoryless_steps  # imports the compiler

    key = repr((point.world, point.representation, point.msa, point.task, point.seed))
    if key not in known:
        primitive = replace(point, msa=MultiStepActions())
        has_more = point.msa.primitives and point.msa.n_actions > primitive.msa.n_actions
        with_fewer = _memoryless_steps(primitive, known) if has_more else None
        known[key] = memoryless_steps(point, layouts_of(point), with_fewer)
    return known[key]


def above_optimum(lines: pd.DataFrame, panels: pd.DataFrame) -> pd.DataFrame:
    """Return the lines whose best memoryless policy needs more steps than the optimum.

    Args:
        lines: panel, line, memoryless.
        panels: panel, optimum.
    """
    both = lines.merge(panels[["panel", "optimum"]], on="panel")
    return both[both["memoryless"] > MORE * both["optimum"]]


def told_of_memoryless(lines: pd.DataFrame, panels: pd.DataFrame) -> list[str]:
    """Return what is known of the best memoryless policies, see `above_optimum`; nothing if nothing is known."""
    if lines["memoryless"].isna().all():
        return []
    about = "Best memoryless policy, one action for each observation:"
    above = above_optimum(lines, panels)
    if not len(above):
        return [f"{about} where it is known, it needs as few steps as the optimum, so these designs can express that."]
    needs = (f"{line['memoryless'] / line['optimum']:.2f} ({line['line']})" for line in above.to_dict("records"))
    return [f"{about} its steps over those of the optimum are {', '.join(dict.fromkeys(needs))}."]
