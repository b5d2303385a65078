"""Connecting to an MLflow tracking store, which is created or migrated if need be."""

from __future__ import annotations

import logging
import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock

from rl_design_space.tracking.address import SQLITE, is_server, sqlite_path
from rl_design_space.tracking.store_errors import as_tracking_error

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: Id of the advisory lock in PostgreSQL under which tables are created.
_CREATION_LOCK = 0x726C2D6473


def configure_mlflow() -> None:
    """Configure MLflow through the environment, before it is imported; what the user has set there wins.

    Telemetry is off, a dead server is noticed within seconds, and MLflow logs nothing below a warning.
    """
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_BACKOFF_FACTOR", "1")
    os.environ.setdefault("MLFLOW_ENABLE_ARTIFACTS_PROGRESS_BAR", "false")
    os.environ.setdefault("MLFLOW_SUPPRESS_PRINTING_URL_TO_STDOUT", "true")
    for noisy, level in (("mlflow", logging.WARNING), ("alembic", logging.WARNING), ("urllib3", logging.ERROR)):
        logging.getLogger(noisy).setLevel(level)


def connect(uri: str, *, creation_timeout: float = 120, writer_timeout: float = 5) -> MlflowClient:
    """Return a client of a tracking store that answers; a SQLite database is created if missing.

    Args:
        uri: URI of the store.
        creation_timeout: seconds to wait for another process that is creating the SQLite database.
        writer_timeout: seconds to wait for another process that is writing to it.

    Raises:
        ConfigError: the store cannot be used.
        StoreUnavailableError: the store cannot be reached or written to at the moment.
    """
    configure_mlflow()
    from mlflow import MlflowClient

    path = sqlite_path(uri)
    try:
        if path is None:
            return _checked(MlflowClient(uri)) if is_server(uri) else _open_database(uri)
        return _open_sqlite(path, creation_timeout, writer_timeout)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system
        raise as_tracking_error(uri, error) from error


def analyze(path: Path, timeout: float = 5) -> None:
    """Update the statistics of SQLite's query planner; without them, charts of many runs take seconds longer.

    Args:
        path: the database.
        timeout: seconds to wait for another process that is writing to it.
    """
    with closing(sqlite3.connect(path, timeout=timeout)) as database:
        database.execute("PRAGMA analysis_limit = 1000")
        database.execute("ANALYZE")
        database.commit()


def _checked(client: MlflowClient) -> MlflowClient:
    """Return a client after a first request has succeeded."""
    client.search_experiments(max_results=1)
    return client


def _open_database(uri: str) -> MlflowClient:
    """Connect once before MLflow does, which retries for an hour; lock while it creates and migrates the tables."""
    import sqlalchemy
    from mlflow import MlflowClient

    engine = sqlalchemy.create_engine(uri, poolclass=sqlalchemy.NullPool)
    with engine.connect() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(sqlalchemy.select(sqlalchemy.func.pg_advisory_lock(_CREATION_LOCK)))
        return _checked(MlflowClient(uri))


def _open_sqlite(path: Path, creation_timeout: float, writer_timeout: float) -> MlflowClient:
    """Create and migrate the database under a lock: two processes at once would corrupt it."""
    from mlflow import MlflowClient

    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{path}.lock", timeout=creation_timeout):
        if not path.exists():
            _create_sqlite(path)
        with closing(sqlite3.connect(path, timeout=writer_timeout)) as database:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("BEGIN IMMEDIATE")
            database.rollback()
        client = _checked(MlflowClient(f"{SQLITE}{path}"))
        analyze(path, writer_timeout)
    return client


def _create_sqlite(path: Path) -> None:
    """Create a database under another name and rename it: one that is created halfway could never be opened."""
    from mlflow import MlflowClient

    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    MlflowClient(f"{SQLITE}{new}").search_experiments(max_results=1)
    new.rename(path)
