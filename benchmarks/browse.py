"""Latency at 10,000 runs: of a table page and a chart of 100 runs in MLflow's UI, and of `load_runs`.

A few real points are recorded, their rows copied by SQL, and the lean server of `rl-design-space ui` asked for what
the UI asks for. The first time after the server's start is cold, the second warm. The disk cache is not emptied.
"""

from __future__ import annotations

import json
import sqlite3
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlencode
from urllib.request import Request, urlopen

import pandas as pd

from benchmarks.processes import run
from benchmarks.tables import number
from rl_design_space.learning.measures import CURVES
from rl_design_space.tracking import MlflowTracking
from rl_design_space.tracking.read import RunReader
from rl_design_space.tracking.sqlite_file import analyze
from rl_design_space.tracking.ui_server import serving

_PORT = 5117
#: Seconds that the server may take for an answer.
_PATIENCE = 600
#: Tables with rows of a run.
_TABLES = ("params", "tags", "latest_metrics", "metrics")


def measure(
    rounds: int, report: Callable[[str], None] = print, *, runs: int = 10_000, learned: int = 4
) -> pd.DataFrame:
    """Fill a database, and start a server every round.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        runs: in the database.
        learned: runs that are learned and recorded; all others are copies of their rows.

    Returns:
        One row a request and round: request, state (cold or warm), round, seconds.
    """
    rows = []
    with TemporaryDirectory() as folder:
        database, experiment = filled(Path(folder), runs, learned)
        report(f"browse: {runs:,} runs, {database.stat().st_size / 2**20:,.0f} MiB")
        for round_ in range(rounds):
            with serving(f"sqlite:///{database}", _PORT, Path(folder) / "artifacts") as address:
                for state in ("cold", "warm"):
                    began = time.perf_counter()
                    ids = [run["info"]["run_id"] for run in _page(address, experiment)["runs"]]
                    loaded = time.perf_counter()
                    _chart(address, ids)
                    drawn = time.perf_counter()
                    times = {"table, first page": loaded - began, "a chart of 100 runs": drawn - loaded}
                    rows += [
                        {"request": what, "state": state, "round": round_, "seconds": seconds}
                        for what, seconds in times.items()
                    ]
            rows += [{**row, "round": round_} for row in _loaded(database, runs)]
            report(f"browse: round {round_ + 1} of {rounds}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Median seconds of each request, cold and warm."""
    return calls.pivot_table(index="request", columns="state", values="seconds", aggfunc="median").reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    return pd.DataFrame(
        [
            {"what": row["request"], "s cold": number(row["cold"]), "s warm": number(row["warm"])}
            for row in frame.to_dict("records")
        ]
    )


def _loaded(database: Path, count: int) -> list[dict[str, Any]]:
    """Seconds that the frame of all runs takes, the first time and the second."""
    address = MlflowTracking(uri=f"sqlite:///{database}").address
    rows = []
    for state in ("cold", "warm"):
        began = time.perf_counter()
        runs = RunReader(address).frame()
        rows.append({"request": "load_runs, all runs", "state": state, "seconds": time.perf_counter() - began})
        if len(runs) != count:
            raise RuntimeError(f"{len(runs):,} runs were loaded, not {count:,}")
    return rows


def _page(address: str, experiment: str) -> dict[str, Any]:
    """The first 100 runs by total steps."""
    body = {"experiment_ids": [experiment], "max_results": 100, "order_by": ["metrics.`total_steps` ASC"]}
    asked = Request(
        f"{address}/ajax-api/2.0/mlflow/runs/search",
        json.dumps(body).encode(),
        {"Content-Type": "application/json"},
    )
    with urlopen(asked, timeout=_PATIENCE) as answer:
        page: dict[str, Any] = json.load(answer)
    return page


def _chart(address: str, ids: list[str]) -> None:
    """The values of a learning curve; the UI asks so for each of its charts, at the same time."""
    query = urlencode({"run_ids": ids, "metric_key": CURVES[0], "max_results": 2500}, doseq=True)
    with urlopen(
        f"{address}/ajax-api/2.0/mlflow/metrics/get-history-bulk-interval?{query}", timeout=_PATIENCE
    ) as answer:
        found = json.load(answer)["metrics"]
    if {value["run_id"] for value in found} != set(ids):
        raise RuntimeError(f"{CURVES[0]}: the server does not have it of all runs")


def filled(folder: Path, runs: int, learned: int) -> tuple[Path, str]:
    """Return a database with learned runs and copies of them, and the id of their experiment."""
    run([sys.executable, "-m", "rl_design_space", "-m", f"seed=range(0,{learned})", f"outputs={folder}"])
    path = folder / "mlflow.db"
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA cache_size = -1000000")
        (experiment,) = database.execute(
            "SELECT experiment_id FROM experiments WHERE name = 'design points'"
        ).fetchone()
        real = [row[0] for row in database.execute("SELECT run_uuid FROM runs WHERE experiment_id = ?", [experiment])]
        for number_ in range(len(real), runs):
            for table in ("runs", *_TABLES):
                _copy(database, table, real[number_ % len(real)], f"{number_:032x}")
        database.commit()
    analyze(path)
    return path, str(experiment)


def _copy(database: sqlite3.Connection, table: str, run: str, copy: str) -> None:
    columns = [row[1] for row in database.execute(f"PRAGMA table_info({table})")]
    values = ", ".join(":copy" if name == "run_uuid" else f'"{name}"' for name in columns)
    database.execute(
        f"INSERT INTO {table} SELECT {values} FROM {table} WHERE run_uuid = :run", {"copy": copy, "run": run}
    )
