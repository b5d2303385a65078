"""The servers that other tests build on: they keep what they are given, go down and up, and leave nothing behind."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.command_runner import environment, finished, heed_interrupts, next_line, wait_until
from tests.servers import MlflowServer, Postgres, needs_postgres
from tests.service import Service, free_port
from tests.tracking.stores import import_mlflow

if TYPE_CHECKING:
    from mlflow import MlflowClient

ROOT = Path(__file__).parent.parent


@pytest.fixture
def client_of(monkeypatch: pytest.MonkeyPatch) -> Callable[[MlflowServer], MlflowClient]:
    """A client without credentials that gives up at once."""
    import_mlflow()
    from mlflow import MlflowClient

    for name in ("MLFLOW_TRACKING_USERNAME", "MLFLOW_TRACKING_PASSWORD"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    monkeypatch.setenv("MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT", "true")
    return lambda server: MlflowClient(server.uri)


def written(client: MlflowClient, experiment: str) -> str:
    """Write a run as a design point has it; its id."""
    from mlflow.entities import Metric, Param

    run = client.create_run(client.create_experiment(experiment)).info.run_id
    curve = [Metric("steps/mean", float(100 - trial), 1_700_000_000_000, trial) for trial in range(5)]
    client.log_batch(run, metrics=curve, params=[Param("world.size", "10")])
    client.log_text(run, "task: {}\n", "config.yaml")
    client.set_terminated(run)
    return run


def check(client: MlflowClient, run: str) -> None:
    """What was written is there."""
    found = client.get_run(run)
    assert found.info.status == "FINISHED"
    assert found.data.params == {"world.size": "10"}
    curve = client.get_metric_history(run, "steps/mean")
    assert [(point.step, point.value) for point in curve] == [(trial, 100 - trial) for trial in range(5)]
    assert Path(client.download_artifacts(run, "config.yaml")).read_text(encoding="utf-8") == "task: {}\n"


@pytest.fixture(scope="module")
def kept() -> dict[str, str]:
    """Runs that a test wrote for the next, by the URI of their server."""
    return {}


@needs_postgres
def test_a_run_is_in_postgresql_and_a_killed_server_refuses(
    mlflow_server: MlflowServer, client_of, kept: dict[str, str]
):
    import psycopg
    from mlflow.exceptions import MlflowException

    client = client_of(mlflow_server)
    run = kept[mlflow_server.uri] = written(client, "kept")
    check(client, run)
    with closing(psycopg.connect(mlflow_server.environment["MLFLOW_BACKEND_STORE_URI"])) as connection:
        query = "select count(*) from metrics where run_uuid = %s"
        assert connection.execute(query, [run]).fetchone() == (5,)
    mlflow_server.kill()
    with pytest.raises(MlflowException, match="refused"):
        client.get_run(run)


@needs_postgres
def test_a_server_is_there_again_for_the_next_test_and_keeps_its_runs(
    mlflow_server: MlflowServer, client_of, kept: dict[str, str]
):
    from mlflow.exceptions import MlflowException

    client = client_of(mlflow_server)
    for run in kept.values():
        check(client, run)
    mlflow_server.stop()
    with pytest.raises(MlflowException, match="refused"):
        client.search_experiments()


@needs_postgres
def test_databases_are_apart_and_ask_for_their_password(postgres: Postgres):
    import psycopg

    one, other = postgres.create(), postgres.create()
    with closing(psycopg.connect(one)) as connection:
        connection.execute("create table mine (value int)")
        connection.commit()
    with closing(psycopg.connect(other)) as connection:
        assert connection.execute("select to_regclass('mine')").fetchone() == (None,)
    user, password = one.removeprefix("postgresql://").partition("@")[0].split(":")
    with pytest.raises(psycopg.OperationalError, match="password authentication failed"):
        psycopg.connect(one.replace(f"{user}:{password}", f"{user}:wrong"))


@needs_postgres
def test_basic_auth_lets_in_whoever_has_the_password(auth_server: MlflowServer, client_of, monkeypatch):
    from mlflow.exceptions import MlflowException

    client = client_of(auth_server)
    with pytest.raises(MlflowException, match="401"):
        client.search_experiments()
    monkeypatch.setenv("MLFLOW_TRACKING_USERNAME", auth_server.username)
    monkeypatch.setenv("MLFLOW_TRACKING_PASSWORD", "wrong")
    with pytest.raises(MlflowException, match="401"):
        client.search_experiments()
    monkeypatch.setenv("MLFLOW_TRACKING_PASSWORD", auth_server.password)
    check(client, written(client, "mine"))


def test_a_service_that_ends_at_once_shows_its_log(tmp_path: Path):
    service = Service(
        command=["sh", "-c", "echo no such luck; exit 3"], ready=lambda: False, port=free_port(), log=tmp_path / "log"
    )
    with pytest.raises(RuntimeError, match="ended:\nno such luck"):
        service.start()
    assert not service.running


def test_a_port_that_is_taken_is_not_free():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", free_port()))
        taken.listen()
        assert taken.getsockname()[1] not in {free_port() for _ in range(50)}


# Runs a cluster, says where, and waits.
HOLDER = """
from tests.servers import postgres_cluster
with postgres_cluster() as cluster:
    print(cluster._process.pid, cluster.folder, flush=True)
    input()
"""


@needs_postgres
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL], ids=lambda how: how.name)
def test_a_cluster_ends_with_the_tests_however_they_end(tmp_path: Path, how: signal.Signals):
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLDER],
        cwd=ROOT,
        env={**environment(tmp_path), "PYTHONPATH": str(ROOT), "TMPDIR": "/tmp"},
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        preexec_fn=heed_interrupts,
    )  # fmt: skip
    pid, folder = next_line(holder).split()
    os.kill(int(pid), 0)
    holder.send_signal(how)
    finished(holder)
    wait_until(lambda: not Path(f"{folder}/data/postmaster.pid").exists())
    # A process that is killed cannot remove its files.
    assert Path(folder).exists() == (how == signal.SIGKILL)
    if how == signal.SIGKILL:
        shutil.rmtree(folder)
