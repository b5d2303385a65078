"""How long one waits for reports, and for the frame of 10,000 runs.

The points of the paper are learned once. Then each report is written by a command of its own, and all by one; what
importing takes is measured beside them. Runs are loaded by `load_runs`, and through MLflow's client as one would write
it, of the same database and of a server on it; each in a new process, so that imports count and nothing is cached.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import pandas as pd

from benchmarks.browse import filled
from benchmarks.processes import run
from benchmarks.tables import number
from rl_design_space.tracking.ui_server import serving

REPORTS = (
    "fig1", "table1", "table2", "fig2", "table3", "fig3", "fig4", "fig5", "table4", "claims", "readings", "all",
)  # fmt: skip
IMPORTS, OURS, CLIENT = "imports of a report", "load_runs", "MlflowClient.search_runs"
_IMPORTS = """
import rl_design_space.commands.report, rl_design_space.plan.study, rl_design_space.tracking.database, sqlalchemy
from rl_design_space.report import QualityMap
"""
_OURS = "import sys, rl_design_space as rds; print(len(rds.load_runs(uri=sys.argv[1])))"
_CLIENT = """
import sys, mlflow, pandas as pd
client = mlflow.MlflowClient(sys.argv[1])
experiment, rows, token = client.get_experiment_by_name("design points").experiment_id, [], None
while token != "":
    page = client.search_runs([experiment], "attributes.status = 'FINISHED'", max_results=1000, page_token=token)
    rows += [{**run.data.params, **run.data.metrics} for run in page]
    token = page.token or ""
print(len(pd.DataFrame(rows)))
"""
_PORT = 5119


def measure(
    rounds: int,
    report: Callable[[str], None] = print,
    *,
    periods: int = 500,
    runs: int = 10_000,
    reports: Sequence[str] = REPORTS,
    study: str = "paper",
) -> pd.DataFrame:
    """Write the reports and load the runs, in turns.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        periods: of a point.
        runs: in the database that is loaded.
        reports: names of the reports, or `all`.
        study: whose points are learned for them.

    Returns:
        One row a case and round: case, round, seconds, cpu (seconds of all processes), of loading also store.
    """
    rows = []
    with TemporaryDirectory() as folder:
        there = [f"task.periods={periods}", f"outputs={folder}/reports"]
        run([sys.executable, "-m", "rl_design_space", f"study={study}", *there])
        database, _ = filled(Path(folder), runs, learned=4)
        uri = f"sqlite:///{database}"
        write = "from rl_design_space.commands.report import main; main()"
        for round_ in range(rounds):
            rows.append({"case": IMPORTS, "store": "", "round": round_, **_timed("-c", _IMPORTS)})
            for name in reports:
                rows.append({"case": name, "store": "", "round": round_, **_timed("-c", write, name, *there)})
                report(f"reports: round {round_ + 1} of {rounds}, {name}")
            with serving(uri, _PORT, Path(folder) / "artifacts") as address:
                for store, place in (("database", uri), ("server", address)):
                    for case, code in ((OURS, _OURS), (CLIENT, _CLIENT)):
                        rows.append({"case": case, "store": store, "round": round_, **_timed("-c", code, place)})
                        report(f"reports: round {round_ + 1} of {rounds}, {case}, {store}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians, and how many times those of `load_runs` from the same store the seconds are."""
    frame = calls.groupby(["case", "store"], sort=False)[["seconds", "cpu"]].median().reset_index()
    ours = frame[frame["case"] == OURS].set_index("store")["seconds"]
    return frame.assign(ratio=frame["seconds"] / frame["store"].map(ours))


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    return pd.DataFrame(
        [
            {
                "what": f"{row['case']}, {row['store']}" if row["store"] else row["case"],
                "s": number(row["seconds"]),
                "CPU s": number(row["cpu"]),
                "over ours": number(row["ratio"]) if row["store"] else "",
            }
            for row in frame.to_dict("records")
        ]
    )


def _timed(*arguments: str) -> dict[str, float]:
    """Run Python with these arguments; return its seconds, and the processor time of it and its children."""
    before, began = _children(), time.perf_counter()
    run([sys.executable, *arguments])
    return {"seconds": time.perf_counter() - began, "cpu": _children() - before}


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
