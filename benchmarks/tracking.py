"""What it costs to record a point, and what learning loses by it.

The tracker process writes behind; its CPU time is that of the command's children. A sweep is run with few points and
with many, and the difference, divided by the points that it has more, is what a point costs. The naive way, MLflow's
fluent API with a call a value, records the same into a database as MLflow makes it. Learning is timed with and without
a tracker, in turns: seconds of the learning threads a move. That is done with points of Table 4, and with the defaults,
which are learned in a tenth of the time.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory

import pandas as pd

from benchmarks.processes import run
from benchmarks.tables import number, spread
from rl_design_space.learning.cores import available_threads

OURS, NAIVE = "rl-design-space", "fluent API, a call a value"


@dataclass(frozen=True)
class Work:
    """Points to learn.

    Attributes:
        overrides: that say which; they are learned with several seeds.
        points: how many there are of each seed.
        few, many: seeds of the smaller and of the larger sweep.
    """

    overrides: tuple[str, ...]
    points: int
    few: int
    many: int


WORK = {"Table 4": Work(("study=table4",), points=18, few=1, many=28), "defaults": Work((), 1, few=20, many=520)}


def measure(
    rounds: int,
    report: Callable[[str], None] = print,
    *,
    works: Mapping[str, Work] = WORK,
    cores: int | None = None,
    naive_points: int = 10,
    empty: Path | None = None,
) -> pd.DataFrame:
    """Record in both ways, and learn with and without a tracker, in turns.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        works: what is learned, by name.
        cores: that may learn; by default all.
        naive_points: points that the naive way records in a round.
        empty: a database that MLflow has made, which both ways copy; None if MLflow is to make one each time.

    Returns:
        One row a case and round: case, round, cpu_ms a point, and of ours slowed: seconds a move over those without,
        and learn_ms, which a point takes a thread without.
    """
    rows = []
    all_threads = cores or available_threads()
    for round_ in range(rounds):
        for name, work in works.items():
            for threads in sorted({max(all_threads - 1, 1), all_threads}):
                case = {"case": f"{OURS}, {name}, {threads} of {all_threads} cores learn", "round": round_}
                rows.append(case | _costs(work, threads, empty, without_first=bool(round_ % 2)))
                report(f"tracking: round {round_ + 1} of {rounds}, {case['case']}")
        rows.append({"case": NAIVE, "round": round_, "cpu_ms": 1e3 * _naive(naive_points, empty)})
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles, and how many times ours the CPU time is, within a round."""
    ours = calls[calls["case"].str.startswith(OURS)].groupby("round")["cpu_ms"].mean()
    grouped = calls.assign(ratio=calls["cpu_ms"] / calls["round"].map(ours)).groupby("case", sort=False)
    parts = {"ratio": grouped["ratio"].median()}
    for name in ("cpu_ms", "slowed", "learn_ms"):
        parts[name] = grouped[name].median()
        parts[f"{name}_q25"] = grouped[name].quantile(0.25)
        parts[f"{name}_q75"] = grouped[name].quantile(0.75)
    return pd.DataFrame(parts).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "way": row["case"],
            "CPU ms a point": spread(row, "cpu_ms", "cpu_ms_q25", "cpu_ms_q75"),
            "over ours": number(row["ratio"]),
            "learning, ms a point": spread(row, "learn_ms", "learn_ms_q25", "learn_ms_q75"),
            "learning, over that without": spread(row, "slowed", "slowed_q25", "slowed_q75"),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _costs(work: Work, threads: int, empty: Path | None, *, without_first: bool) -> dict[str, float]:
    """What is measured in a round; either of the sweeps that are compared comes first in half of the rounds."""
    few = _sweep(work, work.few, threads, empty)
    trackings = ("tracking=none", "tracking=sqlite") if without_first else ("tracking=sqlite", "tracking=none")
    many = {tracking: _sweep(work, work.many, threads, empty, tracking) for tracking in trackings}
    with_, without = many["tracking=sqlite"], many["tracking=none"]
    return {
        "cpu_ms": 1e3 * (with_["tracker_cpu"] - few["tracker_cpu"]) / ((work.many - work.few) * work.points),
        "slowed": (with_["learning"] / with_["moves"]) / (without["learning"] / without["moves"]),
        "learn_ms": 1e3 * without["learning"] / (work.many * work.points),
    }


def _sweep(work: Work, seeds: int, threads: int, empty: Path | None, *more: str) -> dict[str, float]:
    with _folder(empty) as folder:
        sweep = ["-m", *work.overrides, f"seed=range(0,{seeds})", f"threads={threads}", f"outputs={folder}", *more]
        ended = run([sys.executable, "-m", "benchmarks.tracked", *sweep])
        figures: dict[str, float] = json.loads(ended.stderr.splitlines()[-1])
        return figures


def _naive(points: int, empty: Path | None) -> float:
    """Return the CPU seconds a point; making the database does not count."""
    with _folder(empty) as folder:
        ended = run([sys.executable, "-m", "benchmarks.naive", str(folder / "mlflow.db"), str(points)])
        return float(json.loads(ended.stdout.splitlines()[-1])["cpu"]) / points


@contextmanager
def _folder(empty: Path | None) -> Iterator[Path]:
    """A temporary folder, with a copy of a database if there is one to copy."""
    with TemporaryDirectory() as folder:
        if empty:
            copyfile(empty, Path(folder) / "mlflow.db")
        yield Path(folder)
