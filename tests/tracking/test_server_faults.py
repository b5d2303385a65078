"""A tracking server that stops, restarts or requires a login: no result is lost or stored twice."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from threading import Barrier, Thread
from time import sleep
from typing import Any

import pytest
import requests

from rl_design_space.tracking.delivery import deliver_all
from tests.command_runner import PATIENCE, Completed, commands_in, finished, started, wait_until
from tests.servers import MlflowServer, Postgres, needs_postgres
from tests.service import free_port
from tests.tracking.faults import Sabotage
from tests.tracking.stores import import_mlflow, learned, undelivered_tracker_at

pytestmark = needs_postgres

#: Overrides of points that are learned within milliseconds.
TINY = ("-m", "task.periods=3", "task.trials=4", "world.size=4")
SEEDS = "seed=1,2,3"
#: Number of points that a server gets which is killed meanwhile.
POINTS = 20


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., Completed]:
    """Run a command in a folder of its own; it may write nothing except its outputs."""
    run = commands_in(tmp_path)
    return lambda *words, **more: run("rl-design-space", *words, **more)


class Recorded:
    """The runs of an experiment on a server, read with MLflow itself."""

    def __init__(self, uri: str, experiment: str) -> None:
        import_mlflow()
        from mlflow import MlflowClient

        self._client = MlflowClient(uri)
        self._experiment = experiment

    def runs(self) -> list:
        """Return all runs of any status."""
        known = self._client.get_experiment_by_name(self._experiment)
        return list(self._client.search_runs([known.experiment_id])) if known else []

    def check(self, points: int) -> list:
        """Check that every point is stored once, complete and with readable artifacts, and nothing is RUNNING."""
        runs = self.runs()
        times = Counter(run.data.tags["fingerprint"] for run in runs if run.info.status == "FINISHED")
        assert sorted(times.values()) == [1] * points
        assert {run.info.status for run in runs} <= {"FINISHED", "KILLED"}
        for run in runs[:3]:
            files = {file.path: file.file_size for file in self._client.list_artifacts(run.info.run_id)}
            assert files["config.yaml"] > 0
            assert files["periods.npz"] > 0
            assert len(self._client.get_metric_history(run.info.run_id, "steps/mean")) == 4
        return runs


def at(uri: str, experiment: str) -> tuple[str, ...]:
    """Return overrides that name a store and experiments of a test's own in it."""
    return (
        "tracking=server",
        f"tracking.uri={uri}",
        f"tracking.experiment={experiment}",
        f"tracking.sweeps={experiment} s",
    )


def pending(folder: Path) -> int:
    return len(list((folder / "out" / "spool").glob("*/*.record")))


def test_results_stay_pending_while_a_server_is_down(idle_mlflow_server: MlflowServer, command, tmp_path: Path):
    server = idle_mlflow_server
    store = at(server.uri, "away")
    done = command(*TINY, SEEDS, "tracking.patience=1", *store, status=1, MLFLOW_HTTP_REQUEST_MAX_RETRIES="0")
    assert "3 learned now" in done.stdout
    # Three points, and the beginning and end of the sweep.
    assert re.search(r"5 results of .* safe on disk, not yet in http.*(refused|failed)", done.stdout)
    assert "rl-design-space sync" in done.stdout
    assert pending(tmp_path) == 5

    server.start()
    # One of the points is recorded from elsewhere first.
    other = tmp_path / "out" / "elsewhere"
    command(*TINY[1:], "seed=2", *store, outputs=str(other))
    assert "5 records delivered" in command("sync", *store).stdout
    recorded = Recorded(server.uri, "away")
    recorded.check(3)
    assert pending(tmp_path) == 0
    assert command("sync", *store).stdout.startswith("no pending records in ")
    recorded.check(3)


def test_a_server_that_is_killed_and_restarted_gets_every_point_once(
    mlflow_server: MlflowServer, command, tmp_path: Path
):
    import psycopg

    recorded = Recorded(mlflow_server.uri, "killed")
    struck = []

    def strike() -> None:
        wait_until(lambda: 2 <= len(recorded.runs()) < POINTS, pause=0.1)
        struck.append(len(recorded.runs()))
        mlflow_server.kill()
        sleep(1)
        mlflow_server.start()

    sweep = (*TINY, f"seed=range(0,{POINTS})", "tracking.patience=60", *at(mlflow_server.uri, "killed"))
    thread = Thread(target=strike)
    thread.start()
    try:
        done = command(*sweep)
    finally:
        thread.join(PATIENCE)
    assert 0 < struck[0] < POINTS
    assert f"{POINTS} learned now" in done.stdout
    runs = recorded.check(POINTS)
    sweeps = Recorded(mlflow_server.uri, "killed s")
    assert {run.info.status for run in sweeps.runs()} == {"FINISHED"}
    assert pending(tmp_path) == 0
    with closing(psycopg.connect(mlflow_server.environment["MLFLOW_BACKEND_STORE_URI"])) as connection:
        query = "select count(*) from runs join experiments using (experiment_id) where experiments.name = 'killed'"
        assert connection.execute(query).fetchone() == (len(runs),)
    # Nothing is left to do, and what is recorded can be repeated.
    assert f"0 learned now, {POINTS} before" in command(*sweep).stdout
    recorded.check(POINTS)
    finished_run = next(run.info.run_id for run in runs if run.info.status == "FINISHED")
    assert command("rerun", finished_run, *sweep[-4:]).stdout.startswith("identical: ")


@pytest.fixture
def meeting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have two deliveries wait for each other after both have looked for the point."""
    import_mlflow()
    from mlflow import MlflowClient

    barrier, create_run = Barrier(2, timeout=PATIENCE), MlflowClient.create_run

    def delayed(*arguments: Any, **others: Any) -> Any:
        barrier.wait(timeout=PATIENCE)
        return create_run(*arguments, **others)

    monkeypatch.setattr(MlflowClient, "create_run", delayed)


def test_two_machines_record_a_point_once_on_a_real_server(mlflow_server: MlflowServer, tmp_path: Path, meeting: None):
    planned, curves = learned()
    spools = []
    for name in ("one", "other"):
        tracker = undelivered_tracker_at(
            tmp_path / "none.db", uri=mlflow_server.uri, experiment="twice", spool=str(tmp_path / name)
        )
        tracker.record(replace(planned, studies=(name,)), curves)
        spools.append(tracker._spool)
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(lambda spool: deliver_all(spool, PATIENCE), spools)) == ["", ""]
    found = Recorded(mlflow_server.uri, "twice").check(1)
    assert len(found) == 2
    kept = next(run for run in found if run.info.status == "FINISHED")
    assert {"study.one", "study.other"} <= kept.data.tags.keys()


def credentials(server: MlflowServer) -> dict[str, str]:
    return {"MLFLOW_TRACKING_USERNAME": server.username, "MLFLOW_TRACKING_PASSWORD": server.password}


def test_a_server_with_basic_auth(auth_server: MlflowServer, command, tmp_path: Path, monkeypatch):
    store = at(auth_server.uri, "asked")
    sweep = (*TINY, SEEDS, *store)
    outputs = [command(*sweep, status=2)]
    assert re.fullmatch(
        r"error: tracking.uri=http\S+: .*MLFLOW_TRACKING_USERNAME and MLFLOW_TRACKING_PASSWORD.*\n", outputs[0].stderr
    )
    known = credentials(auth_server)
    outputs.append(command(*sweep, **{**known, "MLFLOW_TRACKING_PASSWORD": "wrong"}, status=2))
    assert "does not accept user admin" in outputs[1].stderr
    outputs.append(command(*sweep, **known))
    outputs.append(command(*TINY[1:], *store, "--cfg", "job", **known))
    for name, value in known.items():
        monkeypatch.setenv(name, value)
    runs = Recorded(auth_server.uri, "asked").check(3)
    sweeps = Recorded(auth_server.uri, "asked s").runs()
    stored = [json.dumps(run.to_dictionary()) for run in (*runs, *sweeps)]
    files = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()]
    everything = [each.encode() for done in outputs for each in (done.stdout, done.stderr)] + files
    assert not [
        text for text in (*everything, *(each.encode() for each in stored)) if auth_server.password.encode() in text
    ]


def test_a_user_who_may_only_read_gets_an_error_and_keeps_the_results(
    auth_server: MlflowServer, command, tmp_path: Path
):
    def post(endpoint: str, **content: str) -> None:
        administrator = (auth_server.username, auth_server.password)
        address = f"{auth_server.uri}/api/2.0/mlflow/{endpoint}"
        requests.post(address, json=content, auth=administrator, timeout=30).raise_for_status()

    user = {"username": "reader", "password": "only-to-read-with"}
    post("users/create", **user)
    store = at(auth_server.uri, "read only")
    for experiment in ("read only", "read only s"):  # the administrator, who creates them, owns them
        post("experiments/create", name=experiment)
    reader = {f"MLFLOW_TRACKING_{name.upper()}": value for name, value in user.items()}
    done = command(*TINY, SEEDS, *store, **reader, status=2)
    assert "user reader may not write or read there" in done.stderr
    assert pending(tmp_path) > 0
    assert not list((tmp_path / "out" / "spool").glob("*/aside/*"))
    assert "delivered" in command("sync", *store, **credentials(auth_server)).stdout
    assert pending(tmp_path) == 0


@pytest.mark.parametrize(
    ("uri", "more"),
    [
        ("http://user:secret@host:5000", ()),
        ("http://secret@host:5000", ("--cfg", "job")),
        ("postgresql://user:secret@host/db", ("-m", "seed=1,2")),
        ("postgresql://user@host/db?password=secret", ("--cfg", "job")),
    ],
)
def test_a_password_in_a_command_is_refused_and_not_repeated(command, tmp_path: Path, uri: str, more: tuple[str, ...]):
    done = command("tracking=server", f"tracking.uri={uri}", *more, status=2)
    assert "should not hold a password" in done.stderr
    assert "docs/server.md" in done.stderr
    assert "secret" not in done.stdout + done.stderr
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_postgresql_without_a_server(postgres: Postgres, command, tmp_path: Path, monkeypatch):
    full = postgres.create()
    password = full.partition("@")[0].rpartition(":")[2]
    store = at(full.replace(f":{password}@", "@"), "direct")
    done = command(*TINY, SEEDS, *store, status=2)
    assert re.search("access denied: .*PGPASSWORD", done.stderr)
    assert "password authentication failed" in command(*TINY, SEEDS, *store, PGPASSWORD="wrong", status=2).stderr
    # Two processes find an empty database: one of them creates the tables, the other waits.
    words = (*TINY, *store, "outputs=out")
    with (
        started(tmp_path, *words, "seed=1,2", PGPASSWORD=password) as one,
        started(tmp_path, *words, "seed=2,3", PGPASSWORD=password) as other,
    ):
        for done in map(finished, (one, other)):
            assert done.returncode == 0, done.stdout + done.stderr
    monkeypatch.setenv("PGPASSWORD", password)
    runs = Recorded(full, "direct").check(3)
    assert all((tmp_path / "out" / "artifacts" / "direct" / run.info.run_id).is_dir() for run in runs)
    assert command("rerun", runs[0].info.run_id, *store, PGPASSWORD=password).stdout.startswith("identical: ")
    files = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()]
    assert not [content for content in files if password.encode() in content]


def test_a_database_server_that_is_down_is_given_up_in_time(command, tmp_path: Path):
    """MLflow itself retries for an hour."""
    store = at(f"postgresql://nobody@127.0.0.1:{free_port()}/nothing", "nowhere")
    # The result is there before anything is known about the store.
    with started(tmp_path, *TINY[1:], "tracking.patience=600", "outputs=out", *store) as process:
        wait_until(lambda: "total steps a period" in process.stdout.readline(), process)
        process.kill()
        process.communicate(timeout=PATIENCE)
    done = command(*TINY[1:], "tracking.patience=2", *store, status=1)
    assert "1 result of" in done.stdout
    assert "refused" in command("sync", *store, "tracking.patience=2", status=1).stdout


def test_a_tracker_process_that_is_killed_in_a_batch_for_postgresql_is_restarted(
    mlflow_server: MlflowServer, tmp_path: Path
):
    import psycopg

    # The server's database, which has its tables, without the server.
    uri = mlflow_server.environment["MLFLOW_BACKEND_STORE_URI"]
    password = uri.partition("@")[0].rpartition(":")[2]
    store = ("outputs=out", *at(uri.replace(f":{password}@", "@"), "struck"))
    stages = ("after params 1", "before metrics 1", "before commit 1")
    sabotage = Sabotage(tmp_path, "tracker", PGPASSWORD=password)
    status, output = sabotage.run(*TINY, "seed=range(0,8)", *store, faults=stages)
    assert status == 0, output
    assert pending(tmp_path) == 0
    query = """
        select count(*), count(distinct value), min(status), max(status), count(distinct held) from (
            select value, status, (select count(*) from metrics where metrics.run_uuid = runs.run_uuid) as held
            from runs join tags using (run_uuid) join experiments using (experiment_id)
            where key = 'fingerprint' and experiments.name = 'struck') as points
    """
    with closing(psycopg.connect(uri)) as connection:
        assert connection.execute(query).fetchone() == (8, 8, "FINISHED", "FINISHED", 1)
