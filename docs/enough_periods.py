"""Measure how often the interval of a mean holds the true one when learning stops: `python -m docs.enough_periods`.

Prints the table of docs/decisions/0028-enough-periods.md: numbers of periods are drawn, in the batches of
`learning.precision`, until the precision is reached. Takes a few minutes of a core. With `--fixed`, learning stops when
the usual interval is narrow enough, which takes no account of the looks.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, Direction, Linear, Task
from rl_design_space.learning import simulate
from rl_design_space.learning.precision import Precision, anytime_half_width

#: Periods of the cells of Table 4 that are drawn from, of a seed that nothing else has.
_CELL_PERIODS, _SEED = 100_000, 2**31
_NORMAL_95 = 1.959964
#: Numbers of the first batch and precisions.
_RULES = ((50, 0.1), (100, 0.05), (500, 0.05), (500, 0.02))
_AT_MOST = 20_000


class Population(NamedTuple):
    """Numbers of periods that there could be.

    Attributes:
        draw: returns so many of them.
        mean: of all.
    """

    draw: Callable[[np.random.Generator, int], FloatArray]
    mean: float


class Stop(NamedTuple):
    """What was known when learning stopped.

    Attributes:
        held: whether the interval holds the true mean.
        fixed_held: whether the usual one does, which takes no account of the looks.
        periods: their number.
    """

    held: bool
    fixed_held: bool
    periods: int


def normal() -> Population:
    """Return numbers with a standard deviation of half the mean."""
    return Population(lambda rng, count: rng.normal(1, 0.5, count), 1.0)


def skewed() -> Population:
    """Return log-normal numbers, with a skewness of 6."""
    return Population(lambda rng, count: rng.lognormal(0, 1, count), float(np.exp(0.5)))


def one_in_twenty() -> Population:
    """Return numbers of which one in twenty is about forty times the others."""

    def draw(rng: np.random.Generator, count: int) -> FloatArray:
        few = rng.random(count) < 0.05
        numbers: FloatArray = np.where(few, rng.exponential(1000, count), 20 + rng.exponential(5, count))
        return numbers

    return Population(draw, 0.05 * 1000 + 0.95 * 25)


def cell(point: DesignPoint, periods: int = _CELL_PERIODS) -> Population:
    """Return the total steps of periods of a point."""
    task = replace(point.task, periods=periods)
    every = simulate(replace(point, seed=_SEED, task=task)).total_steps
    return Population(lambda rng, count: every[rng.integers(len(every), size=count)], float(every.mean()))


def stop(population: Population, rule: Precision, rng: np.random.Generator, *, fixed: bool = False) -> Stop:
    """Draw numbers until they are enough, and return what is known then.

    Args:
        population: what is drawn from.
        rule: when they are enough.
        rng: draws.
        fixed: whether the usual interval decides.
    """
    numbers, look = np.empty(0), rule.first
    while True:
        numbers = np.concatenate([numbers, population.draw(rng, look - len(numbers))])
        half, mean = anytime_half_width(numbers, rule.first), float(numbers.mean())
        usual = _NORMAL_95 * float(numbers.std(ddof=1)) / len(numbers) ** 0.5
        following = rule.following(len(numbers), (usual if fixed else half) / abs(mean))
        if following is None:
            off = abs(mean - population.mean)
            return Stop(off <= half, off <= usual, len(numbers))
        look = following


def table(populations: Mapping[str, Population], samples: int, *, fixed: bool) -> list[str]:
    """Return the rows of the table: how often both intervals hold, and how many periods were needed on average."""
    rows = []
    for name, population in populations.items():
        for first, relative in _RULES:
            rule, rng = Precision(relative, "total_steps", first, _AT_MOST), np.random.default_rng(first)
            found = np.array([stop(population, rule, rng, fixed=fixed) for _ in range(samples)], dtype=np.float64)
            held, usual, periods = found.mean(axis=0)
            rows.append(f"| {name} | {first} | {relative:.0%} | {held:.1%} | {usual:.1%} | {periods:,.0f} |")
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=2000, help="samples for each row (default: %(default)s)")
    parser.add_argument("--fixed", action="store_true", help="stop when the usual interval is narrow enough")
    arguments = parser.parse_args()
    design = DesignPoint(exploration=Linear(k=0.02), task=Task())
    populations = {
        "normal": normal(),
        "log-normal": skewed(),
        "one in twenty": one_in_twenty(),
        "ad hoc, d = 10, n = 3": cell(design),
        "direction, d = 10, n = 3": cell(replace(design, representation=Direction(goals="remaining"))),
    }
    print("| numbers | first batch | precision | holds at the stop | usual interval | periods |")
    print("|---|---|---|---|---|---|")
    print("\n".join(table(populations, arguments.samples, fixed=arguments.fixed)))


if __name__ == "__main__":
    main()
