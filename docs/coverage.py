"""Measure how often intervals over several seeds hold the true mean: `python -m docs.coverage`.

Prints the table of docs/decisions/0016-several-seeds.md: 30 periods of a small task, divided among 1 to 30 seeds,
learned by the kernel and resampled in four ways. Takes about ten minutes. With `--tails` it prints that of
docs/decisions/0023-heavy-tails.md: samples of real periods of cells of Table 4.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from scipy import stats

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.averaging import mean_of_runs
from rl_design_space.analysis.pooling import Repetition
from rl_design_space.analysis.statistics import mean_estimate, percentile_interval
from rl_design_space.design import DesignPoint, Direction, Linear, Task, Torus
from rl_design_space.learning import simulate

_PERIODS = 30
#: Numbers of seeds among which the periods are divided.
_SEEDS = (1, 2, 6, 30)
_RESAMPLES = 2000
#: Periods that stand for all there could be, of a seed that no sample has.
_TRUTH_PERIODS, _TRUTH_SEED = 200_000, 2**31
_TASK = Task(trials=20, periods=_PERIODS)
_DESIGNS = {
    "ad hoc": DesignPoint(world=Torus(size=5), task=_TASK, exploration=Linear(k=0.05)),
    "direction": DesignPoint(
        world=Torus(size=5), task=_TASK, exploration=Linear(k=0.05), representation=Direction(goals="all")
    ),
}


class Cell(NamedTuple):
    """A direction cell of Table 4.

    Attributes:
        observed: goals that a direction observes.
        size: of the grid.
        goals: their number.
        periods: number of periods that stand for all there could be; fewer where one takes longer.
    """

    observed: Literal["all", "remaining"]
    size: int
    goals: int
    periods: int = 200_000


_CELLS = [
    *(Cell("remaining", 10, goals) for goals in (1, 2, 3)),
    *(Cell("all", 10, goals) for goals in (2, 3)),
    Cell("remaining", 20, 1),
    Cell("remaining", 20, 2, 20_000),
    Cell("remaining", 20, 3, 20_000),
    Cell("remaining", 30, 1, 100_000),
    Cell("remaining", 30, 2, 50_000),
    Cell("remaining", 30, 3, 20_000),
]
_SIZES = (500, 5000, 10_000, 20_000, 40_000)
#: (seeds, periods) values to the ends of an interval of their mean.
Interval = Callable[[FloatArray], tuple[float, float]]


def learn(point: DesignPoint, seed: int, periods: int) -> FloatArray:
    """Return the total steps of each period."""
    return simulate(replace(point, seed=seed, task=replace(point.task, periods=periods)), threads=1).total_steps


def ours(values: FloatArray) -> tuple[float, float]:
    """Return the interval of the reports."""
    found = mean_of_runs(list(values), [Repetition("design", seed) for seed in range(len(values))])
    return found.low, found.high


def within_seeds(values: FloatArray) -> tuple[float, float]:
    """Resample the periods of each seed."""
    return _percentiles(_means_of_seeds(values).mean(axis=1))


def seeds_then_periods(values: FloatArray) -> tuple[float, float]:
    """Resample seeds, then the periods of each."""
    rng = np.random.default_rng(1)
    seeds, periods = values.shape
    chosen = rng.integers(seeds, size=(_RESAMPLES, seeds, 1))
    return _percentiles(values[chosen, rng.integers(periods, size=(_RESAMPLES, seeds, periods))].mean(axis=(1, 2)))


def seeds_alone(values: FloatArray) -> tuple[float, float]:
    """Resample seeds, each with all of its periods."""
    rng = np.random.default_rng(1)
    means = values.mean(axis=1)
    return _percentiles(means[rng.integers(len(means), size=(_RESAMPLES, len(means)))].mean(axis=1))


def _means_of_seeds(values: FloatArray) -> FloatArray:
    rng = np.random.default_rng(1)
    seeds, periods = values.shape
    drawn = rng.integers(periods, size=(_RESAMPLES, seeds, periods))
    means: FloatArray = values[np.arange(seeds)[:, np.newaxis], drawn].mean(axis=2)
    return means


def _percentiles(samples: FloatArray) -> tuple[float, float]:
    low, high = percentile_interval(samples)
    return float(low), float(high)


METHODS: dict[str, Interval] = {
    "pooled (ours)": ours,
    "periods within seeds": within_seeds,
    "seeds, then periods": seeds_then_periods,
    "seeds alone": seeds_alone,
}


def main() -> None:
    """Print a Markdown table of shares of intervals that hold the true mean, and their mean widths."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=1000, help="samples for each cell (default: %(default)s)")
    parser.add_argument("--tails", action="store_true", help="of heavy tails, by number of periods")
    parser.add_argument("--size", type=int, help="with --tails: cells of this grid size alone")
    arguments = parser.parse_args()
    samples = arguments.samples
    if arguments.tails:
        print_tails(samples, [cell for cell in _CELLS if arguments.size in (None, cell.size)])
        return
    truth = {name: learn(point, _TRUTH_SEED, _TRUTH_PERIODS).mean() for name, point in _DESIGNS.items()}
    print(f"| statistic | intervals by | {' | '.join(f'{n} × {_PERIODS // n}' for n in _SEEDS)} |")
    print(f"|---|---|{'---|' * len(_SEEDS)}")
    cells: dict[tuple[str, str], list[str]] = {}
    for seeds in _SEEDS:
        drawn = [_sample(number, seeds) for number in range(samples)]
        statistics = {
            "mean of ad hoc": ([each["ad hoc"] for each in drawn], truth["ad hoc"]),
            "mean of direction": ([each["direction"] for each in drawn], truth["direction"]),
            "direction minus ad hoc": (
                [each["direction"] - each["ad hoc"] for each in drawn],
                truth["direction"] - truth["ad hoc"],
            ),
        }
        for statistic, (values, true) in statistics.items():
            for method, interval in METHODS.items():
                ends = np.array([interval(each) for each in values])
                held = ((ends[:, 0] <= true) & (true <= ends[:, 1])).mean()
                width = (ends[:, 1] - ends[:, 0]).mean()
                cells.setdefault((statistic, method), []).append(f"{held:.1%} ({width:,.0f})")
    for (statistic, method), texts in cells.items():
        print(f"| {statistic} | {method} | {' | '.join(texts)} |")


def print_tails(samples: int, cells: Sequence[Cell]) -> None:
    """Print how often the interval of a mean holds that of many periods, by cell of Table 4 and number of periods."""
    print(f"| cell | skewness | {' | '.join(f'{size:,}' for size in _SIZES)} |")
    print(f"|---|---|{'---|' * len(_SIZES)}")
    for cell in cells:
        point = DesignPoint(
            world=Torus(size=cell.size),
            task=Task(goals=cell.goals),
            exploration=Linear(k=0.02),
            representation=Direction(goals=cell.observed),
        )
        every = learn(point, _TRUTH_SEED, cell.periods)
        held = [f"{_share_held(every, each, samples):.1%}" for each in _SIZES]
        name = f"d = {cell.size}, n = {cell.goals}, {cell.observed} goals"
        print(f"| {name} | {stats.skew(every):.0f} | {' | '.join(held)} |", flush=True)


def _share_held(every: FloatArray, size: int, samples: int) -> float:
    """Return how often the interval of the mean of so many periods holds that of every period."""
    rng = np.random.default_rng(size)
    found = (mean_estimate(every[rng.integers(len(every), size=size)]) for _ in range(samples))
    return float(np.mean([low <= every.mean() <= high for _, low, high in found]))


def _sample(number: int, seeds: int) -> dict[str, FloatArray]:
    """Return the values of designs on the same seeds, (seeds, periods) each; no two samples share a seed."""
    first = (_SEEDS.index(seeds) * 100_000 + number) * _PERIODS
    return {
        name: np.array([learn(point, first + seed, _PERIODS // seeds) for seed in range(seeds)])
        for name, point in _DESIGNS.items()
    }


if __name__ == "__main__":
    main()
