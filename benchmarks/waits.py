"""How long one waits for a sweep, from the command to the last record, in an empty folder.

The floor of the first point is what MLflow alone takes: its import, and creating a database, which we do once a machine
and copy from then on.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from benchmarks.client import LIMIT, ROOT
from benchmarks.tables import number, spread

#: The command line.
COMMAND = (sys.executable, "-m", "rl_design_space")
_FLOOR = """
import sys
from mlflow import MlflowClient
MlflowClient(f"sqlite:///{sys.argv[1]}/mlflow.db").search_experiments()
"""


@dataclass(frozen=True)
class Wait:
    """Something to wait for.

    Attributes:
        command: its last argument is the empty folder, after `outputs=` or alone.
        goal: seconds on two idle cores; NaN if there is none.
        empty_cache: whether it is the first time on this machine that a database is needed.
    """

    command: tuple[str, ...]
    goal: float = float("nan")
    empty_cache: bool = False


def waits(many: int = 10_000, few: int = 300) -> dict[str, Wait]:
    """Return what is waited for, by name."""
    return {
        "MLflow alone: import, and create a database": Wait((sys.executable, "-c", _FLOOR, ""), empty_cache=True),
        "first point on a machine": Wait((*COMMAND, "outputs="), empty_cache=True),
        "first point in a folder": Wait((*COMMAND, "outputs="), 4),
        f"{few:,} points of 30 periods": Wait(
            (*COMMAND, "-m", "task.periods=30", f"seed=range(0,{few})", "outputs="), 15
        ),
        f"{many:,} points of 10 periods": Wait(
            (*COMMAND, "-m", "task.periods=10", f"seed=range(0,{many})", f"max_points={many}", "outputs="), 240
        ),
    }


def measure(
    rounds: int, report: Callable[[str], None] = print, *, cases: Mapping[str, Wait] | None = None
) -> pd.DataFrame:
    """Run every command in turn.

    Returns:
        One row a case and round: case, round, seconds, goal, first (seconds until anything is printed), and cpu.
    """
    rows = []
    for round_ in range(rounds):
        for name, wait in (cases or waits()).items():
            rows.append({"case": name, "round": round_, "goal": wait.goal, **_waited(wait)})
            report(f"waits: round {round_ + 1} of {rounds}, {name}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles."""
    grouped = calls.groupby("case", sort=False)
    parts = {name: grouped[name].median() for name in ("goal", "first", "cpu", "seconds")}
    parts["seconds_q25"], parts["seconds_q75"] = (grouped["seconds"].quantile(each) for each in (0.25, 0.75))
    return pd.DataFrame(parts).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "wait for": row["case"],
            "wall s": spread(row, "seconds", "seconds_q25", "seconds_q75"),
            "goal": number(row["goal"]),
            "s until the first line": number(row["first"]),
            "CPU s of all processes": number(row["cpu"]),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _waited(wait: Wait) -> dict[str, float]:
    with TemporaryDirectory() as folder, TemporaryDirectory() as cache:
        command = [*wait.command[:-1], f"{wait.command[-1]}{folder}"]
        env = {**os.environ, "MLFLOW_DISABLE_TELEMETRY": "true"}
        if wait.empty_cache:
            env["XDG_CACHE_HOME"] = cache
        log = Path(cache) / "errors"
        before, started, first = _cpu_of_children(), time.perf_counter(), float("nan")
        with (
            log.open("wb") as errors,
            subprocess.Popen(command, cwd=ROOT, env=env, stdout=subprocess.PIPE, stderr=errors, text=True) as process,
        ):
            assert process.stdout is not None
            if process.stdout.readline():
                first = time.perf_counter() - started
            process.communicate(timeout=LIMIT)
        seconds = time.perf_counter() - started
        if process.returncode:
            raise RuntimeError(f"{command} ended with status {process.returncode}: {log.read_text()[-2000:]}")
        return {"seconds": seconds, "first": first, "cpu": _cpu_of_children() - before}


def _cpu_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
