"""The set of the best among the cells of a table."""

from __future__ import annotations

from collections.abc import Sequence

from rl_design_space.analysis.best import RESAMPLES, BestSet, best_set
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import ONLY_SCALARS, measure
from rl_design_space.report.designs import Designs, Numbers, OwnNumbers
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs

#: Mark of the designs of the set, and column that says which they are.
STAR, IN_SET = "★", "in_best_set"
BEST_NOTE = f"{STAR}: cannot be told from the best cell at 95 %, all cells together, paired by period."
#: Cells above which the set is not looked for.
_MOST = 400


def among_best(cells: Sequence[Sequence[Point]], runs: Runs, value: str) -> list[bool] | None:
    """Return whether each cell cannot be told from the best one; None if that is not defined, as without periods.

    Args:
        cells: the points of each cell; those without a run are not in the set.
        runs: that hold the points.
        value: a scalar or measure.
    """
    recorded = [[point for point in points if point.run] for points in cells]
    filled = [points for points in recorded if points]
    if value in ONLY_SCALARS or not 1 < len(filled) <= _MOST:
        return None
    try:
        designs = Designs(runs, [point for points in filled for point in points])
        if len(designs) != len(filled):
            return None  # cells that are means over designs
        own = designs.of_own_periods(value, RESAMPLES)
        numbers, periods = own or designs.numbers(value, RESAMPLES)[0], designs.most_periods if own else designs.periods
    except ConfigError:
        return None  # no common periods, or none kept
    inside = iter(compared(numbers, periods, value).inside.tolist())
    return [bool(points) and next(inside) for points in recorded]


def compared(numbers: Numbers | OwnNumbers, periods: int, value: str) -> BestSet:
    """Return which designs cannot be told from the best by their numbers of a measure."""
    descending = measure(value).largest_is_best
    return best_set(numbers.value, numbers.samples, numbers.each, periods=periods, largest_is_best=descending)
