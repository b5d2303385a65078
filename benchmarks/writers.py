"""How many points a store takes: from one process and from several, and from one with MLflow's client.

Records are there before the clock starts, so that delivery alone is measured. Writers have a spool each, as machines
that share a database have.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import pandas as pd

from benchmarks.client import LIMIT, ROOT
from benchmarks.tables import number, spread
from benchmarks.writer import CLIENT, OURS

if TYPE_CHECKING:
    from tests.service import Service

SQLITE, POSTGRESQL, SERVER = "SQLite", "PostgreSQL", "tracking server"
#: Points that a writer records.
POINTS = {SQLITE: 200, POSTGRESQL: 200, SERVER: 60}
#: Ways of recording, with the number of processes.
WAYS = ((OURS, 1), (OURS, 2), (OURS, 4), (CLIENT, 1))


def measure(
    rounds: int,
    report: Callable[[str], None] = print,
    *,
    points: Mapping[str, int] = POINTS,
    ways: Sequence[tuple[str, int]] = WAYS,
) -> pd.DataFrame:
    """Record into an empty store of each kind, in all ways in turn.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        points: that a writer records, by kind of store.
        ways: of recording, with the number of processes.

    Returns:
        One row a store, way, number of writers and round: points a second, and CPU ms a point: of the writers, of those
        in transactions, and of the database's or server's processes.
    """
    rows = []
    for round_ in range(rounds):
        for kind, count in points.items():
            for way, several in ways:
                with ExitStack() as stack:
                    folder = Path(stack.enter_context(TemporaryDirectory()))
                    try:
                        store, cpu_of_store = stack.enter_context(_store(kind, folder))
                    except ImportError as error:
                        report(f"writers: {kind} is left out, {error}")
                        break
                    figures = _written(store, cpu_of_store, folder, way, several, count)
                rows.append({"store": kind, "way": way, "writers": several, "round": round_, **figures})
                report(f"writers: round {round_ + 1} of {rounds}, {kind}, {way}, {several}")
    return pd.DataFrame(rows)


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles; how many times the CPU time of one of our writers a way takes, within a round."""
    of_one = calls[(calls["way"] == OURS) & (calls["writers"] == 1)].set_index(["store", "round"])["cpu_ms"]
    ours = of_one.reindex(pd.MultiIndex.from_frame(calls[["store", "round"]])).to_numpy()
    grouped = calls.assign(ratio=calls["cpu_ms"] / ours).groupby(["store", "way", "writers"], sort=False)
    parts = {name: grouped[name].median() for name in ("ratio", "in_transactions_ms", "store_ms")}
    for name in ("cpu_ms", "rate"):
        parts[name] = grouped[name].median()
        parts[f"{name}_q25"] = grouped[name].quantile(0.25)
        parts[f"{name}_q75"] = grouped[name].quantile(0.75)
    return pd.DataFrame(parts).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "store": row["store"],
            "by": row["way"],
            "writers": row["writers"],
            "CPU ms a point": spread(row, "cpu_ms", "cpu_ms_q25", "cpu_ms_q75"),
            "over ours": number(row["ratio"]),
            "in transactions": number(row["in_transactions_ms"]),
            "CPU ms of the store": number(row["store_ms"]),
            "points a second": spread(row, "rate", "rate_q25", "rate_q75"),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _written(
    store: str, cpu_of_store: Callable[[], float], folder: Path, way: str, writers: int, points: int
) -> dict[str, float]:
    """Record points from several processes at once; return what it took."""
    with ExitStack() as stack:
        processes = []
        for writer in range(writers):  # one after the other, because the first one creates the store
            command = [sys.executable, "-m", "benchmarks.writer", store, str(folder / f"spool{writer}"), way]
            process = subprocess.Popen(
                [*command, str(writer * (points + 1)), str(points)],
                cwd=ROOT,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            stack.callback(process.wait, LIMIT)
            stack.callback(process.kill)
            assert process.stdout is not None
            if process.stdout.readline() != "ready\n":
                raise RuntimeError(f"{command} has failed")
            processes.append(process)
        before = cpu_of_store()
        for process in processes:
            assert process.stdin is not None
            process.stdin.write("\n")
            process.stdin.flush()
        figures = [json.loads(process.communicate(timeout=LIMIT)[0]) for process in processes]
        of_store = cpu_of_store() - before
    if any(each["pending"] for each in figures):
        raise RuntimeError(f"{store}: not all records were delivered")
    number_of_points = writers * points
    return {
        "rate": number_of_points / max(each["seconds"] for each in figures),
        "cpu_ms": 1e3 * sum(each["cpu"] for each in figures) / number_of_points,
        "in_transactions_ms": 1e3 * sum(each["in_transactions"] for each in figures) / number_of_points,
        "store_ms": 1e3 * of_store / number_of_points,
    }


@contextmanager
def _store(kind: str, folder: Path) -> Iterator[tuple[str, Callable[[], float]]]:
    """Start an empty store; yield its URI, and a function that returns the CPU seconds of its processes so far.

    Raises:
        ImportError: a package or program for it is missing.
    """
    if kind == SQLITE:
        yield f"sqlite:///{folder}/mlflow.db", lambda: 0.0
        return
    from tests.servers import PROGRAMS, MlflowServer, postgres_cluster

    if PROGRAMS is None:
        raise ImportError("PostgreSQL's server is not installed")
    with postgres_cluster() as cluster:
        uri = cluster.create()
        if kind == POSTGRESQL:
            yield uri, lambda: _cpu_of(cluster)
        else:
            with MlflowServer(uri, folder) as server:
                yield server.uri, lambda: _cpu_of(server)


def _cpu_of(service: Service) -> float:
    """Return the CPU seconds of a service and its children, of those that have ended, too."""
    import psutil  # type: ignore[import-untyped]

    assert service._process
    process, total = psutil.Process(service._process.pid), 0.0
    for each in [process, *process.children(recursive=True)]:
        times = each.cpu_times()
        total += times.user + times.system + times.children_user + times.children_system
    return total
