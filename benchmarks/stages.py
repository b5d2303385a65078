"""CPU time of points with stages, relative to points of one stage that make the same steps.

`python -m benchmarks.stages` prints a table: a row for each representation and curriculum.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from time import process_time
from typing import NamedTuple

import numpy as np

from rl_design_space import DesignPoint
from rl_design_space.learning import LearningCurves, simulate

_REPRESENTATIONS = ("ad_hoc", "distance", "direction")
_POINT = ("task.periods=200", "task.trials=50", "exploration=linear")


class Case(NamedTuple):
    """A curriculum, and the size of the grid of each of its stages."""

    name: str
    sizes: tuple[int, ...]
    overrides: tuple[str, ...]


CASES = (
    Case("5 → 10", (5, 10), ("curriculum=coarse_to_fine", "curriculum.sizes=[5]")),
    Case("5 → 10, by observation", (5, 10), ("curriculum=coarse_to_fine", "curriculum.carry=same_observation")),
    Case("10 → 30", (10, 30), ("curriculum=coarse_to_fine", "curriculum.sizes=[10]")),
    Case("5 → 10 → 20", (5, 10, 20), ("curriculum=coarse_to_fine", "curriculum.sizes=[5,10]")),
    Case("3 layouts", (10, 10, 10), ("curriculum=new_goals", "curriculum.layouts=3")),
)


class Cost(NamedTuple):
    """CPU seconds of a point with stages, and those that its steps cost in points of one stage."""

    seconds: float
    of_its_steps: float


def cost(case: Case, overrides: Sequence[str], turns: int) -> Cost:
    """Return the least of several turns; in each the point with stages and those of one stage are learned.

    Args:
        case: the curriculum.
        overrides: of all points.
        turns: number of turns.
    """
    alone = list(dict.fromkeys(case.sizes))
    points = [_point(*overrides, f"world.size={case.sizes[-1]}", *case.overrides)]
    points += [_point(*overrides, f"world.size={size}") for size in alone]
    taken = [[_learned(point) for point in points] for _ in range(turns)]
    staged, *single = taken[0]
    seconds, *of_single = np.min([[each for each, _ in turn] for turn in taken], axis=0).tolist()
    of_step = {
        size: each / learned.steps.sum() for size, each, (_, learned) in zip(alone, of_single, single, strict=True)
    }
    steps = [staged[1].stage(number).steps.sum() for number in range(1, len(case.sizes) + 1)]
    return Cost(seconds, sum(of_step[size] * made for size, made in zip(case.sizes, steps, strict=True)))


def _point(*overrides: str) -> DesignPoint:
    return DesignPoint.from_overrides(overrides)


def _learned(point: DesignPoint) -> tuple[float, LearningCurves]:
    began = process_time()
    learned = simulate(point, threads=1)
    return process_time() - began, learned


def _rows(turns: int) -> Iterator[str]:
    yield "| representation | stages | ms | ms of its steps | ratio |"
    yield "|---|---|---|---|---|"
    for representation, case in product(_REPRESENTATIONS, CASES):
        found = cost(case, [*_POINT, f"representation={representation}"], turns)
        ms, expected = 1e3 * found.seconds, 1e3 * found.of_its_steps
        yield f"| {representation} | {case.name} | {ms:.1f} | {expected:.1f} | {ms / expected:.2f} |"


if __name__ == "__main__":
    for row in _rows(turns=15):
        print(row, flush=True)
