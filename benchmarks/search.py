"""How many steps it takes to find the best of a thousand points: a race, beside others that may use as many.

The full sweep of each study is learned once and kept; each way then takes from it the periods that it asks for. The
race, its error rate and those of a full sweep are measured on resampled periods, too.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.search_methods import Found, halved, optimised, raced
from benchmarks.search_studies import STUDIES, Sweep, full_sweep
from benchmarks.tables import number
from rl_design_space.analysis.best import best_means

RACE, HALVING, OPTUNA = "race", "successive halving", "Optuna, TPE"


def measure(
    rounds: int,
    report: Callable[[str], None],
    *,
    folder: Path,
    periods: int = 300,
    studies: tuple[str, ...] = (*STUDIES,),
) -> pd.DataFrame:
    """Return a row for each study, way and round.

    Args:
        rounds: seeds of Optuna.
        report: told what goes on.
        folder: for the numbers of full sweeps.
        periods: of each point.
        studies: names.
    """
    rows = []
    for name in studies:
        sweep = full_sweep(name, folder, report, periods)
        report(f"{name}: comparing")
        full = best_means(sweep.values)
        race = raced(sweep.values)
        found = {RACE: [race], HALVING: [halved(sweep.values, race.steps)]}
        found[OPTUNA] = [optimised(sweep, race.steps, seed) for seed in range(rounds)]
        for way, results in found.items():
            rows += [_row(sweep, full.inside, full.leader, way, seed, each) for seed, each in enumerate(results)]
    return pd.DataFrame(rows)


def _row(sweep: Sweep, inside: np.ndarray, leader: int, way: str, seed: int, found: Found) -> dict[str, object]:
    means = sweep.values.mean(axis=0)
    return {
        "study": sweep.name,
        "points": len(means),
        "best_set": int(inside.sum()),
        "way": way,
        "seed": seed,
        "steps": found.steps / sweep.values.sum(),
        "is_best": found.winner == leader,
        "loss": means[found.winner] / means[leader] - 1,
        "of_best_set": int((found.inside & inside).sum()),
        "others": int((found.inside & ~inside).sum()),
    }


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Return a row for each study and way, means over seeds."""
    keys = ["study", "points", "best_set", "way"]
    return calls.groupby(keys, sort=False).mean(numeric_only=False).drop(columns="seed").reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the table that people read."""
    return pd.DataFrame(
        {
            "study": [f"{row.study}, {row.points:,} points" for row in frame.itertuples()],
            "way": frame["way"],
            "steps of the full sweep": frame["steps"].map("{:.1%}".format),
            "finds the leader": frame["is_best"].map("{:.0%}".format),
            "its best loses": frame["loss"].map("{:.1%}".format),
            "of the best set": [f"{number(row.of_best_set)} of {row.best_set}" for row in frame.itertuples()],
            "others in its set": frame["others"].map(number),
        }
    )
