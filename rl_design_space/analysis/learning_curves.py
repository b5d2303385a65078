"""Learning curves of points with their uncertainty, and the random walk as their baseline."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import (
    mean_estimate,
    mean_share_estimate,
    percentile_interval,
    resampled_means,
)
from rl_design_space.design import StochasticWorld, World, possible_cells
from rl_design_space.design.ways import reached_from
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves

if TYPE_CHECKING:
    import pandas as pd


def curve_frame(recorded: LearningCurves) -> pd.DataFrame:
    """Return the steps of each trial over periods, a row for each trial.

    Returns:
        trial; mean with ci_low and ci_high (95 %, bootstrap over periods); median, q10, q90; failed, the share of
        periods in which the trial misses the final goal.
    """
    import pandas as pd

    steps = recorded.steps.astype(np.float64)
    low, high = percentile_interval(resampled_means(steps))
    q10, median, q90 = np.quantile(steps, (0.1, 0.5, 0.9), axis=0)
    return pd.DataFrame(
        {
            "trial": np.arange(steps.shape[1]),
            "mean": steps.mean(axis=0),
            "ci_low": low,
            "ci_high": high,
            "median": median,
            "q10": q10,
            "q90": q90,
            "failed": 1 - recorded.success.mean(axis=0),
        }
    )


def curve_summary(recorded: LearningCurves) -> dict[str, float]:
    """Return scalars of a learning curve; means come with their 95 % intervals."""
    equal = np.full((1, len(recorded.steps)), 1 / len(recorded.steps))
    total, failed, final = (
        (mean_share_estimate if measure(name).is_share else mean_estimate)(each)
        for name in ("total_steps", "failed_trials", "final_steps_over_optimum")
        if (each := measure(name).each(recorded)) is not None
    )
    return {
        "total_steps": total.value,
        "total_low": total.low,
        "total_high": total.high,
        "trials_to_final": float(measure("trials_to_final").samples(recorded, equal)[0]),
        "final_over_optimum": final.value,
        "final_low": final.low,
        "final_high": final.high,
        "failed": failed.value,
        "failed_low": failed.low,
        "failed_high": failed.high,
        "exploration": float(recorded.epsilon.sum()),
    }


def random_walk_steps(world: World, layouts: NDArray[np.int32]) -> float:
    """Return the expected steps of a uniformly random walk through all goals in order, mean over layouts.

    The value is exact, without a step cap. With the fundamental matrix Z = (I - P + 1π)⁻¹ of a walk P whose
    stationary distribution is π, the walk from i to j ≠ i takes (z_jj - z_ij) / π_j (Kemeny and Snell, "Finite Markov
    Chains", 1960, section 4.4): one inverse, however many goals there are.

    Args:
        world: the world.
        layouts: (periods, 1 + n_goals) start and goals, each different from the one before, all mutually reachable.
    """
    next_cell, share_of = _ways(world)
    met = reached_from(next_cell, int(layouts[0, 0]))
    cells = int(met.sum())
    number = np.cumsum(met) - 1  # without cells that cannot be reached, such as obstacles
    walk = np.zeros((cells, cells))
    for there, share in zip(next_cell[:, met], share_of[:, met], strict=True):
        np.add.at(walk, (np.arange(cells), number[there]), share)
    away = np.eye(cells) - walk
    often = np.linalg.solve((away + 1).T, np.ones(cells))  # π (I - P) = 0 and Σ π = 1 in one system
    fundamental = np.linalg.inv(away + often)
    origins, goals = number[layouts[:, :-1]], number[layouts[:, 1:]]
    legs = (fundamental[goals, goals] - fundamental[origins, goals]) / often[goals]
    return float(legs.sum(axis=1).mean())


def _ways(world: World) -> tuple[NDArray[np.int32], FloatArray]:
    """Return the cells that a random step may lead to, (ways, cells), and how probably."""
    if not isinstance(world, StochasticWorld):
        next_cell = world.next_cell()
        return next_cell, np.full(next_cell.shape, 1 / len(next_cell))
    outcomes = world.outcomes()
    shares = np.moveaxis(outcomes.probabilities, -1, 1).reshape(-1, outcomes.cells.shape[1])
    return possible_cells(outcomes), shares / len(outcomes.cells)
