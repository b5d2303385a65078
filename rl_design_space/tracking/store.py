"""Opening an MLflow tracking store so that it can be relied on."""

from __future__ import annotations

import errno
import logging
import os
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from mlflow import MlflowClient

_SQLITE = "sqlite:///"
#: Seconds to wait for another process that is creating the database, and for one that is writing to it.
_CREATION_PATIENCE, _WRITER_PATIENCE = 120, 5
#: What databases say that can be used again in a while.
_PASSING_WORDS = ("locked", "busy", "full", "connection", "connect", "starting up", "shutting down", "i/o")
_SERVER_ERROR = 500


class StoreUnavailableError(Exception):
    """A store cannot be used at the moment; it may be in a while."""


@dataclass(frozen=True)
class StoreAddress:
    """Where results are recorded.

    Attributes:
        uri: of the tracking store.
        experiment: name of the experiment that holds the design points.
        sweeps: name of the experiment that holds a summary run for each sweep.
    """

    uri: str
    experiment: str
    sweeps: str

    @property
    def is_server(self) -> bool:
        """Whether it is a tracking server, not a database."""
        return is_server(self.uri)


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
            client = MlflowClient(uri)
            client.search_experiments(max_results=1)
            return client
        return _open_sqlite(path)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system
        if passes(error):
            raise StoreUnavailableError(f"{uri}: {reason(error)}") from error
        raise ConfigError.at("tracking.uri", uri, f"cannot be used: {reason(error)}") from error


def is_server(uri: str) -> bool:
    """Whether a URI is that of a tracking server."""
    return uri.startswith(("http:", "https:", "databricks"))


def sqlite_path(uri: str) -> Path | None:
    """The database file that a SQLite URI names, absolute; None for any other store."""
    return Path(uri.removeprefix(_SQLITE)).absolute() if uri.startswith(_SQLITE) else None


def absolute(uri: str) -> str:
    """The same store, from whatever folder."""
    path = sqlite_path(uri)
    return f"{_SQLITE}{path}" if path else uri


def passes(error: BaseException) -> bool:
    """Whether an error is one of the moment: a lock, a full disk, a server that is away or in trouble itself."""
    from mlflow.exceptions import MlflowException
    from requests.exceptions import RequestException
    from sqlalchemy.exc import DBAPIError

    if isinstance(error, (StoreUnavailableError, Timeout, RequestException, ConnectionError)):
        return True
    if isinstance(error, (DBAPIError, sqlite3.OperationalError)):
        return any(word in str(error).lower() for word in _PASSING_WORDS)
    if isinstance(error, OSError):
        return error.errno in (errno.ENOSPC, errno.EDQUOT)
    if isinstance(error, MlflowException):
        cause = error.__cause__ or error.__context__
        if cause is not None and passes(cause):
            return True
        # Of a server: what it answers when its own database is away. Of a database, they are all kinds of things.
        status: int = error.get_http_status_code()  # type: ignore[no-untyped-call]
        return status >= _SERVER_ERROR and _speaks_of_the_moment(str(error))
    return False


def reason(error: BaseException) -> str:
    """What is wrong, in one line."""
    if isinstance(error, Timeout):
        return "another process has been creating it for minutes"
    first_line = next(iter(str(error).strip().splitlines()), type(error).__name__)
    return first_line.partition(" with exception ")[0]


def deleted_experiment(key: str, name: str) -> ConfigError:
    """What to say of an experiment that somebody has deleted; `key` is where its name is configured."""
    return ConfigError.at(f"tracking.{key}", name, "was deleted in this store; restore it or use another name")


def _speaks_of_the_moment(text: str) -> bool:
    return "API request" in text or any(word in text.lower() for word in _PASSING_WORDS)


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
        analyze(path)
    return client


def analyze(path: Path) -> None:
    """Tell SQLite's planner how its tables have grown; charts of many runs take seconds less."""
    with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
        database.execute("PRAGMA analysis_limit = 1000")
        database.execute("ANALYZE")
        database.commit()
