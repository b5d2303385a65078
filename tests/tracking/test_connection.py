"""Connecting to a store: a new database, a shared one, a locked one, and URIs of no store."""

from __future__ import annotations

import os
import socket
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from filelock import FileLock

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.mlflow_client import configure_mlflow
from rl_design_space.tracking.store_errors import StoreUnavailableError
from tests.command_runner import finished, next_line
from tests.tracking.stores import import_mlflow, tracker_at


@pytest.fixture(autouse=True)
def _mlflow() -> None:
    import_mlflow()


def pragma(database: Path, name: str) -> object:
    with closing(sqlite3.connect(database)) as connection:
        return connection.execute(f"PRAGMA {name}").fetchone()[0]


def test_a_new_database_allows_readers_beside_a_writer(empty_database: Path):
    assert pragma(empty_database, "journal_mode") == "wal"


def test_the_query_planner_has_statistics(database: Path):
    connect(f"sqlite:///{database}")
    with closing(sqlite3.connect(database)) as connection:
        assert connection.execute("select count(*) from sqlite_master where name = 'sqlite_stat1'").fetchone() == (1,)


CREATES = """
import sys
from rl_design_space.tracking.connection import connect
import mlflow.store.tracking.sqlalchemy_store
print("ready", flush=True)
sys.stdin.readline()
print(connect(sys.argv[1]).search_experiments()[0].name, flush=True)
"""


def test_processes_that_create_the_same_database_at_once_all_succeed(tmp_path: Path):
    uri = f"sqlite:///{tmp_path}/new/mlflow.db"
    command = [sys.executable, "-c", CREATES, uri]
    pipe = subprocess.PIPE
    processes = [subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) for _ in range(2)]
    # All imports are done before the race begins.
    for process in processes:
        assert next_line(process) == "ready\n"
    for process in processes:
        process.stdin.write("go\n")
        process.stdin.flush()
    for process in processes:
        done = finished(process)
        assert (done.returncode, done.stdout) == (0, "Default\n"), done.stderr
    assert pragma(tmp_path / "new" / "mlflow.db", "integrity_check") == "ok"


def test_a_database_that_another_process_writes_to_is_unavailable(database: Path):
    with closing(sqlite3.connect(database, isolation_level=None)) as writer:
        writer.execute("BEGIN EXCLUSIVE")
        with pytest.raises(StoreUnavailableError, match=r"sqlite:.*mlflow\.db: .*locked"):
            connect(f"sqlite:///{database}", writer_timeout=0.05)
        writer.execute("ROLLBACK")
    connect(f"sqlite:///{database}")


def test_a_database_that_another_process_creates_is_unavailable(database: Path):
    message = r"sqlite:.*mlflow\.db: another process"
    with FileLock(f"{database}.lock"), pytest.raises(StoreUnavailableError, match=message):
        connect(f"sqlite:///{database}", creation_timeout=0.05)
    connect(f"sqlite:///{database}")


def query(path: Path) -> None:
    """Query a store as a sweep does before it begins."""
    tracker_at(path, spool=str(path.parent.parent / "spool")).finished(["0" * 64])


USES = [lambda path: connect(f"sqlite:///{path}"), query]


@pytest.mark.parametrize("use", USES)
def test_a_file_that_is_not_a_database_is_reported_and_not_changed(tmp_path: Path, use):
    path, content = tmp_path / "in" / "notes.txt", "colour: red\n" * 100
    path.parent.mkdir()
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"tracking\.uri=.*notes\.txt: cannot be used: .*file is not a database"):
        use(path)
    assert path.read_text(encoding="utf-8") == content
    assert [other.name for other in path.parent.iterdir() if other.suffix not in (".lock", ".claims")] == ["notes.txt"]


@pytest.mark.parametrize("use", USES)
def test_a_folder_in_place_of_a_database_is_reported(tmp_path: Path, use):
    (tmp_path / "in" / "folder").mkdir(parents=True)
    with pytest.raises(ConfigError, match=r"cannot be used: .*unable to open database file"):
        use(tmp_path / "in" / "folder")


def test_a_database_of_another_version_of_mlflow_is_reported(database: Path):
    with closing(sqlite3.connect(database)) as other:
        other.execute("update alembic_version set version_num = 'of another version'")
        other.commit()
    with pytest.raises(ConfigError, match=r"tracking\.uri=.*cannot be used: Detected out-of-date database schema"):
        connect(f"sqlite:///{database}")


def test_a_database_of_another_program_is_reported(tmp_path: Path):
    with closing(sqlite3.connect(tmp_path / "other.db")) as other:
        other.execute("create table alembic_version (version_num text)")
        other.execute("insert into alembic_version values ('of another program')")
        other.commit()
    with pytest.raises(ConfigError, match=r"tracking\.uri=.*other\.db: cannot be used"):
        connect(f"sqlite:///{tmp_path}/other.db")


def test_a_folder_that_cannot_be_created_is_reported(tmp_path: Path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"tracking\.uri=.*file/mlflow\.db: cannot be used"):
        connect(f"sqlite:///{tmp_path}/file/mlflow.db")


@pytest.mark.parametrize(
    "uri",
    [
        "sqlite:mlflow.db",
        "postgresql+no_such_driver://localhost/mlflow",
        "mysql+no_such_driver://localhost/mlflow",
        "gopher://localhost",
        "file:///srv/mlruns",
        "databricks:x",
    ],
)
def test_a_store_that_cannot_be_opened_is_reported(uri: str):
    with pytest.raises(ConfigError, match=r"tracking\.uri=") as caught:
        connect(uri)
    assert str(caught.value).startswith(f"tracking.uri={uri}: cannot be used: ")
    assert len(str(caught.value).splitlines()) == 1


def test_a_driver_that_is_not_installed_is_reported(monkeypatch: pytest.MonkeyPatch):
    for driver in ("psycopg", "psycopg2"):
        monkeypatch.setitem(sys.modules, driver, None)
    with pytest.raises(ConfigError, match=r"tracking\.uri=postgresql://127\.0\.0\.1:9/x: cannot be used: .*psycopg"):
        connect("postgresql://127.0.0.1:9/x")


def test_a_server_that_does_not_answer_is_unavailable(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    with pytest.raises(StoreUnavailableError, match=r"http://127\.0\.0\.1:9: API request to"):
        connect("http://127.0.0.1:9")


@pytest.mark.timeout(60)
def test_a_server_that_accepts_and_never_answers_is_unavailable(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    monkeypatch.delenv("MLFLOW_HTTP_REQUEST_TIMEOUT", raising=False)
    configure_mlflow(patience=1)
    with socket.create_server(("127.0.0.1", 0)) as silent, pytest.raises(StoreUnavailableError, match="API request"):
        connect(f"http://127.0.0.1:{silent.getsockname()[1]}")


def test_telemetry_is_off(database: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv("MLFLOW_DISABLE_TELEMETRY", raising=False)
    connect(f"sqlite:///{database}")
    assert os.environ["MLFLOW_DISABLE_TELEMETRY"] == "true"
