"""Opening an MLflow tracking store so that it can be relied on."""

from __future__ import annotations

import logging
import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock

from rl_design_space.tracking.address import SQLITE, is_server, sqlite_path
from rl_design_space.tracking.store_errors import translated

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: Seconds to wait for another process that is creating the database, and for one that is writing to it.
_CREATION_PATIENCE, _WRITER_PATIENCE = 120, 5
#: Of the lock in PostgreSQL under which tables are created.
_CREATION_LOCK = 0x726C2D6473


def configure_mlflow() -> None:
    """Settings of MLflow that hold from its first import on, each unless the user has made it otherwise.

    No telemetry leaves the machine, a dead server is noticed in seconds, and MLflow is quiet.
    """
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_BACKOFF_FACTOR", "1")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    for noisy, level in (("mlflow", logging.WARNING), ("alembic", logging.WARNING), ("urllib3", logging.ERROR)):
        logging.getLogger(noisy).setLevel(level)


def connect(uri: str) -> MlflowClient:
    """A client of a tracking store that is known to answer; a SQLite database is created if need be.

    Raises:
        ConfigError: the store is of no use.
        StoreUnavailableError: it cannot be reached or written to at the moment.
    """
    configure_mlflow()
    from mlflow import MlflowClient

    path = sqlite_path(uri)
    try:
        if path is None:
            return _answering(MlflowClient(uri)) if is_server(uri) else _open_database(uri)
        return _open_sqlite(path)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system
        raise translated(uri, error) from error


def _answering(client: MlflowClient) -> MlflowClient:
    client.search_experiments(max_results=1)
    return client


def _open_database(uri: str) -> MlflowClient:
    """Connect once before MLflow does, which tries for an hour; hold a lock while it creates and migrates tables."""
    import sqlalchemy
    from mlflow import MlflowClient

    engine = sqlalchemy.create_engine(uri, poolclass=sqlalchemy.NullPool)
    with engine.connect() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(sqlalchemy.select(sqlalchemy.func.pg_advisory_lock(_CREATION_LOCK)))
        return _answering(MlflowClient(uri))


def _open_sqlite(path: Path) -> MlflowClient:
    """Create and migrate the database under a lock: two processes that do so at once would break it."""
    from mlflow import MlflowClient

    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{path}.lock", timeout=_CREATION_PATIENCE):
        if not path.exists():
            _create_sqlite(path)
        with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("BEGIN IMMEDIATE")
            database.rollback()
        client = _answering(MlflowClient(f"{SQLITE}{path}"))
        analyze(path)
    return client


def _create_sqlite(path: Path) -> None:
    """Create a database under another name: one that is half created would be of no use for ever."""
    from mlflow import MlflowClient

    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    MlflowClient(f"{SQLITE}{new}").search_experiments(max_results=1)
    new.rename(path)


def analyze(path: Path) -> None:
    """Tell SQLite's planner how its tables have grown; charts of many runs take seconds less."""
    with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
        database.execute("PRAGMA analysis_limit = 1000")
        database.execute("ANALYZE")
        database.commit()
