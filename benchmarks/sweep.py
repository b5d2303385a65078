"""What a point costs beside its learning and its record: CPU and memory of sweeps of points that learn nothing.

A sweep is run with few points and with many, each in a process of its own; the difference, divided by the points that
it has more, is what a point costs, and the start of the process drops out. Hydra's own sweeper and launcher run the
same command, with fewer points, because each takes them a fifth of a second or more.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from benchmarks.processes import run
from benchmarks.tables import number, spread

OURS, STOCK = "rl-design-space", "hydra/sweeper=basic hydra/launcher=basic"
#: Points of the smaller and of the larger sweep.
SIZES = {OURS: (100, 2100), STOCK: (5, 45)}


def measure(
    rounds: int, report: Callable[[str], None] = print, *, sizes: Mapping[str, tuple[int, int]] = SIZES
) -> pd.DataFrame:
    """Run both sweeps of every case in turn.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        sizes: points of the smaller and of the larger sweep, by case.

    Returns:
        One row a case and round: case, round, points, cpu_ms and kib of a point, files of the larger sweep.
    """
    rows = []
    for round_ in range(rounds):
        for case, (smaller, larger) in sizes.items():
            few, many, more = _run(case, smaller), _run(case, larger), larger - smaller
            cpu, kept = ((many[name] - few[name]) / more for name in ("cpu", "bytes"))
            cost = {"points": more, "cpu_ms": 1e3 * cpu, "kib": kept / 2**10, "files": many["files"]}
            rows.append({"case": case, "round": round_, **cost})
        report(f"sweep: round {round_ + 1} of {rounds}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles of CPU time and memory, and how many times ours the CPU time is, within a round."""
    ours = calls[calls["case"] == OURS].set_index("round")["cpu_ms"]
    grouped = calls.assign(ratio=calls["cpu_ms"] / calls["round"].map(ours)).groupby("case", sort=False)
    return pd.DataFrame(
        {
            "points": grouped["points"].median(),
            "cpu_ms": grouped["cpu_ms"].median(),
            "cpu_ms_q25": grouped["cpu_ms"].quantile(0.25),
            "cpu_ms_q75": grouped["cpu_ms"].quantile(0.75),
            "ratio": grouped["ratio"].median(),
            "kib": grouped["kib"].median(),
            "files": grouped["files"].median(),
        }
    ).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "sweep": row["case"],
            "points": number(row["points"]),
            "CPU ms a point": spread(row, "cpu_ms", "cpu_ms_q25", "cpu_ms_q75"),
            "over ours": number(row["ratio"]),
            "KiB kept a point": number(row["kib"]),
            "files of a sweep": number(row["files"]),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _run(case: str, points: int) -> dict[str, float]:
    """CPU seconds, bytes and files of a sweep of so many points."""
    with TemporaryDirectory() as folder:
        plugins = case.split() if case != OURS else []
        sweep = ["-m", "tracking=none", f"outputs={folder}", f"seed=range(0,{points})", *plugins]
        ended = run([sys.executable, "-m", "benchmarks.noop", *sweep])
        figures: dict[str, float] = json.loads(ended.stderr.splitlines()[-1])
        return {**figures, "files": sum(path.is_file() for path in Path(folder).rglob("*"))}
