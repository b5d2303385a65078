"""Opening an MLflow tracking store so that it can be relied on."""

from __future__ import annotations

import logging
import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from mlflow import MlflowClient

_SQLITE = "sqlite:///"
#: Seconds to wait for another process that is creating the database, and for one that is writing to it.
_CREATION_PATIENCE, _WRITER_PATIENCE = 120, 5


def connect(uri: str) -> MlflowClient:
    """A client of a tracking store that is known to answer; a SQLite database is created if need be.

    Raises:
        ConfigError: the store cannot be opened, written to or reached.
    """
    # Set before the first import: no telemetry leaves the machine, and a dead server is noticed in seconds.
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_BACKOFF_FACTOR", "1")
    for noisy, level in (("mlflow", logging.WARNING), ("alembic", logging.WARNING), ("urllib3", logging.ERROR)):
        logging.getLogger(noisy).setLevel(level)
    from mlflow import MlflowClient

    path = sqlite_path(uri)
    try:
        if path is None:
            client = MlflowClient(uri)
            client.search_experiments(max_results=1)
            return client
        return _open_sqlite(path)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system: the store is of no use
        raise ConfigError.at("tracking.uri", uri, f"cannot be used: {_reason(error)}") from error


def sqlite_path(uri: str) -> Path | None:
    """The database file that a SQLite URI names, absolute; None for any other store."""
    return Path(uri.removeprefix(_SQLITE)).absolute() if uri.startswith(_SQLITE) else None


def _open_sqlite(path: Path) -> MlflowClient:
    """Create and migrate the database under a lock: two processes that do so at once would break it."""
    from mlflow import MlflowClient

    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{path}.lock", timeout=_CREATION_PATIENCE):
        with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("BEGIN IMMEDIATE")
            database.rollback()
        client = MlflowClient(f"{_SQLITE}{path}")
        client.search_experiments(max_results=1)
        with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
            database.execute("PRAGMA analysis_limit = 1000")
            database.execute("ANALYZE")
            database.commit()
    return client


def _reason(error: Exception) -> str:
    if isinstance(error, Timeout):
        return "another process has been creating it for minutes"
    first_line = next(iter(str(error).strip().splitlines()), type(error).__name__)
    return first_line.partition(" with exception ")[0]
