"""Writing into a tracking server: the runs are those of MLflow's client, each once, over the worst of networks."""

from __future__ import annotations

import random
from collections import Counter
from contextlib import suppress
from pathlib import Path
from threading import Lock

import pytest
import requests
import sqlalchemy
from mlflow import MlflowClient

from rl_design_space.tracking import client_writer
from rl_design_space.tracking.client_runs import ClientRuns
from rl_design_space.tracking.delivery import Delivery, deliver_all
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.tracker import SweepEnding
from tests.servers import MlflowServer, needs_postgres
from tests.tracking.stores import COMMAND, learned, plan_of, runs, undelivered_tracker_at

pytestmark = needs_postgres


def tracker_of(server: MlflowServer, folder: Path, experiment: str) -> MlflowTracker:
    """Return a tracker of a server whose records stay pending."""
    names = {"experiment": experiment, "sweeps": f"{experiment} s"}
    return undelivered_tracker_at(folder / experiment / "none", uri=server.uri, **names)


#: Tables of what runs hold, and what two sweeps cannot have in common.
TABLES, OWN = ("params", "tags", "metrics", "latest_metrics"), ("rl_design_space.spool", "rl_design_space.sweep")


def contents(server: MlflowServer, experiment: str) -> dict[str, tuple]:
    """Return what the runs of an experiment hold except for ids and ends, by name."""
    client, engine = MlflowClient(server.uri), sqlalchemy.create_engine(server.environment["MLFLOW_BACKEND_STORE_URI"])
    found = {}
    for run in runs(client, experiment):
        info = run.info
        with engine.connect() as connection:
            rows = {
                table: sorted(
                    repr({name: value for name, value in row.items() if name != "run_uuid"}).replace(info.run_id, "RUN")
                    for row in connection.execute(
                        sqlalchemy.text(f"select * from {table} where run_uuid = :run"), {"run": info.run_id}
                    ).mappings()
                    if row["key"] not in OWN
                )
                for table in TABLES
            }
        folder = Path(client.download_artifacts(info.run_id, ""))
        files = {path.name: path.read_bytes() for path in folder.iterdir()}
        found[info.run_name] = (info.status, info.start_time, info.user_id, rows, files)
    engine.dispose()
    return found


def test_a_server_holds_what_the_client_writes(mlflow_server: MlflowServer, tmp_path: Path, monkeypatch):
    # More values than a request may hold.
    points = [learned("task.trials=400"), learned("seed=1", "representation=direction", "exploration=linear")]
    found = {}
    monkeypatch.setattr("time.time", lambda: 1.75e9)
    for way in ("quickly", "by client"):
        tracker = tracker_of(mlflow_server, tmp_path, way)
        sweep = tracker.open_sweep(plan_of(*(planned for planned, _ in points)), COMMAND)
        for planned, curves in points:
            tracker.record(planned, curves)
        sweep.close(SweepEnding("FAILED", "1 failed", {"done": 2}, {"the command": "an error"}, {}))
        if way == "by client":
            monkeypatch.setattr(client_writer, "ServerRuns", ClientRuns)
        assert deliver_all(tracker._spool, 5) == ""
        found[way] = (contents(mlflow_server, way), contents(mlflow_server, f"{way} s"))
    of_points, of_sweeps = found["by client"]
    assert (len(of_points), len(of_sweeps)) == (2, 1)
    assert max(len(rows["metrics"]) for *_, rows, _ in of_points.values()) > 1000
    assert found["quickly"] == found["by client"]


class PowerCutError(BaseException):
    """Ends delivery as a killed process would."""


class WorstNetwork:
    """Breaks requests before or after they have taken effect, or cuts the power.

    Args:
        seed: of what happens.
    """

    def __init__(self, seed: int) -> None:
        self.struck: Counter[str] = Counter()
        self._random, self._lock = random.Random(seed), Lock()
        self._original = requests.Session.request

    def request(self, session: requests.Session, *args: object, **kwargs: object) -> requests.Response:
        with self._lock:
            when = self._random.choices(["before", "after", "never"], [1, 1, 8])[0]
            error = self._random.choice([requests.ConnectionError("connection reset"), PowerCutError()])
            self.struck[f"{type(error).__name__} {when}"] += 1
        if when == "before":
            raise error
        response = self._original(session, *args, **kwargs)
        if when == "after":
            raise error
        return response


@pytest.mark.timeout(120)
def test_points_in_flight_are_stored_once_over_the_worst_of_networks(
    mlflow_server: MlflowServer, tmp_path: Path, monkeypatch
):
    tracker, points = tracker_of(mlflow_server, tmp_path, "worst"), [learned(f"seed={seed}") for seed in range(6)]
    for planned, curves in points:
        tracker.record(planned, curves)
    network = WorstNetwork(seed=1)
    with monkeypatch.context() as patch:
        patch.setattr(requests.Session, "request", lambda *args, **kwargs: network.request(*args, **kwargs))
        patch.setattr(Delivery.__init__, "__kwdefaults__", {"first_pause": 0.01})
        while tracker._spool.pending():
            with suppress(PowerCutError):
                deliver_all(tracker._spool, 5)
    assert {f"{error} {when}" for error in ("ConnectionError", "PowerCutError") for when in ("before", "after")} < set(
        network.struck
    )
    assert tracker._spool.quarantined() == []
    found = runs(MlflowClient(mlflow_server.uri), "worst")
    assert sorted(run.data.tags["fingerprint"] for run in found) == sorted(planned.fingerprint for planned, _ in points)
    held = contents(mlflow_server, "worst")
    assert len(held) == len(points)
    assert {(status, *sorted(files)) for status, *_, files in held.values()} == {
        ("FINISHED", "config.yaml", "curve.svg", "periods.npz")
    }
    assert len({tuple(len(rows[table]) for table in TABLES) for *_, rows, _ in held.values()}) == 1
