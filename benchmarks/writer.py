"""A process that records points: `python -m benchmarks.writer STORE FOLDER WAY FIRST POINTS`.

It learns one point, whose result stands for that of all seeds from FIRST on, and opens the store with a first record.
Then it prints a line, waits for one, delivers the other records, and prints what that took as JSON.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from threading import Event
from typing import Any

from rl_design_space.learning import simulate
from rl_design_space.plan.planner import plan_point
from rl_design_space.tracking import client_writer, database_tables
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.client_runs import ClientRuns
from rl_design_space.tracking.database_writer import DatabaseWriter
from rl_design_space.tracking.delivery import Delivery
from rl_design_space.tracking.mlflow_client import configure_mlflow
from rl_design_space.tracking.process import forget_notebooks
from rl_design_space.tracking.record import point_record
from rl_design_space.tracking.spool import Spool

#: As the tracker process does, or step by step with MLflow's client.
OURS, CLIENT = "rl-design-space", "MLflow's client"
#: Seconds without any delivery after which to give up.
_PATIENCE = 300
#: CPU seconds in transactions.
_in_transactions: list[float] = []


def main() -> None:
    """Fill a spool and deliver it."""
    store, folder, way = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
    first, points = int(sys.argv[4]), int(sys.argv[5])
    configure_mlflow(_PATIENCE)
    if way == CLIENT:
        database_tables.REVISIONS = frozenset()
        client_writer.ServerRuns = ClientRuns  # type: ignore[attr-defined,assignment]
    else:
        forget_notebooks()
        DatabaseWriter._transaction = _timed(DatabaseWriter._transaction)  # type: ignore[method-assign]
    spool = Spool.of(folder, StoreAddress(store, "points", "sweeps"))
    with spool.lock, closing(Delivery(spool, _note, Event())) as delivery:
        _fill(spool, first, 1)
        delivery.run_until_empty(_PATIENCE)
        _fill(spool, first + 1, points)
        _in_transactions.clear()
        print("ready", flush=True)
        sys.stdin.readline()
        cpu, seconds = time.process_time(), time.perf_counter()
        delivery.run_until_empty(_PATIENCE)
        figures = {
            "cpu": time.process_time() - cpu,
            "seconds": time.perf_counter() - seconds,
            "in_transactions": sum(_in_transactions),
            "pending": len(spool.pending()),
        }
    print(json.dumps(figures), flush=True)


def _fill(spool: Spool, first: int, points: int) -> None:
    learned = simulate(plan_point().point)
    for seed in range(first, first + points):
        spool.write(point_record(plan_point([f"seed={seed}"]), learned, {}))


def _timed(transaction: Any) -> Any:
    @contextmanager
    def timed(*arguments: Any) -> Iterator[Any]:
        with transaction(*arguments) as batch:
            begun = time.process_time()
            yield batch
            _in_transactions.append(time.process_time() - begun)

    return timed


def _note(problem: str | None) -> None:
    if problem:
        print(problem, file=sys.stderr)


if __name__ == "__main__":
    main()
