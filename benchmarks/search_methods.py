"""Ways to find the best of many points: a race, successive halving, and Optuna, on the numbers of a full sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.search_studies import Sweep
from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.best import best_means
from rl_design_space.analysis.race import Look, behind, looks, matrix

#: One in so many points stays at each rung of successive halving; most trials of Optuna, many of which repeat others.
_KEPT, _TRIALS = 3, 1000


@dataclass(frozen=True)
class Found:
    """What a method found.

    Attributes:
        steps: that it took.
        winner: the point that it calls the best.
        inside: the points that it cannot tell from the best, (points,).
    """

    steps: float
    winner: int
    inside: NDArray[np.bool_]


def raced(values: FloatArray, at: Sequence[Look] | None = None) -> Found:
    """Race the points.

    Args:
        values: (periods, points) of the full sweep, of which a point takes the first ones.
        at: the looks.
    """
    at = at or looks(len(values))
    counts = np.full(values.shape[1], at[0].periods)
    for look, following in zip(at, [*at[1:], None], strict=True):
        worse = behind(_taken(values, counts), look)
        while (again := ~worse & (counts < look.periods)).any():
            counts[again] = look.periods
            worse = behind(_taken(values, counts), look)
        if (~worse).sum() < 2 or following is None:
            break
        counts[~worse] = following.periods
    return _judged(values, counts)


def halved(values: FloatArray, steps: float) -> Found:
    """Keep a third of the points again and again, beginning with as many periods as these steps allow.

    Jamieson and Talwalkar, "Non-stochastic best arm identification", AISTATS 2016; a third, as in Hyperband.
    """
    rungs = [_rungs(values, first) for first in range(2, len(values))]
    fitting = [counts for counts in rungs if _steps(values, counts) <= steps]
    return _judged(values, fitting[-1] if fitting else rungs[0])


def _rungs(values: FloatArray, first: int) -> NDArray[np.int_]:
    """Return how many periods successive halving gives each point if it begins with so many."""
    counts, left, periods = np.zeros(values.shape[1], dtype=int), np.arange(values.shape[1]), first
    while True:
        counts[left] = periods
        if periods == len(values) or len(left) == 1:
            return counts
        means = values[:periods, left].mean(axis=0)
        left = left[np.argsort(means, kind="stable")[: max(1, len(left) // _KEPT)]]
        periods = min(periods * _KEPT, len(values))


def optimised(sweep: Sweep, steps: float, seed: int) -> Found:
    """Let Optuna's TPE sampler choose points with all their periods, until these steps are used up."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed))
    counts = np.zeros(sweep.values.shape[1], dtype=int)
    spent, cost, means = 0.0, sweep.values.sum(axis=0), sweep.values.mean(axis=0)
    for _ in range(_TRIALS):
        trial = study.ask()
        chosen = {
            name: trial.suggest_categorical(name, list(values)) for name, values in sweep.choices.items()
        }
        number = sweep.number(chosen)
        if not counts[number]:
            if spent + cost[number] > steps:
                break
            spent += cost[number]
            counts[number] = len(sweep.values)
        study.tell(trial, float(means[number]))
    return _judged(sweep.values, counts)


def _taken(values: FloatArray, counts: NDArray[np.int_]) -> list[FloatArray]:
    return [values[:count, point] for point, count in enumerate(counts.tolist())]


def _judged(values: FloatArray, counts: NDArray[np.int_]) -> Found:
    """Return the best of the points that were tried."""
    tried = np.flatnonzero(counts)
    found = best_means(matrix([values[: counts[point], point] for point in tried]))
    inside = np.zeros(values.shape[1], dtype=bool)
    inside[tried] = found.inside
    return Found(_steps(values, counts), int(tried[found.leader]), inside)


def _steps(values: FloatArray, counts: NDArray[np.int_]) -> float:
    return float(sum(values[:count, point].sum() for point, count in enumerate(counts.tolist())))
