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
_SERVER_ERROR, _TOO_MANY = 500, 429
#: What a server answers to whom it does not know, and to who may not do this; what databases say to both.
_UNKNOWN, _FORBIDDEN = 401, 403
_DENYING_WORDS = ("authentication failed", "no password supplied", "permission denied", "pg_hba", '" does not exist')
#: Of the lock in PostgreSQL under which tables are created.
_CREATION_LOCK = 0x726C2D6473


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
            return _answering(MlflowClient(uri)) if is_server(uri) else _open_database(uri)
        return _open_sqlite(path)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system
        raise translated(uri, error) from error


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


def translated(uri: str, error: Exception) -> ConfigError | StoreUnavailableError:
    """An error of a store as ours."""
    if denied := denial(uri, error):
        return denied
    if passes(error):
        return StoreUnavailableError(f"{uri}: {reason(error)}")
    return ConfigError.at("tracking.uri", uri, f"cannot be used: {reason(error)}")


def denial(uri: str, error: BaseException) -> ConfigError | None:
    """What to say if a store does not let its user do what was wanted; None if that is not what is wrong."""
    status = _denying_status(error)
    if status is None:
        return None
    if not is_server(uri):
        where = "" if sqlite_path(uri) else "; a password belongs in the environment, PGPASSWORD for PostgreSQL"
        return ConfigError.at("tracking.uri", uri, f"access denied: {reason(error)}{where}")
    user = os.environ.get("MLFLOW_TRACKING_USERNAME")
    if status == _FORBIDDEN:
        who = f"user {user}" if user else "you"
        return ConfigError.at("tracking.uri", uri, f"{who} may not write or read there; its administrator can allow it")
    expected = (
        f"the server does not know user {user} with the password in MLFLOW_TRACKING_PASSWORD"
        if user
        else "the server asks who you are: set MLFLOW_TRACKING_USERNAME and MLFLOW_TRACKING_PASSWORD in the environment"
    )
    return ConfigError.at("tracking.uri", uri, expected)


def passes(error: BaseException) -> bool:
    """Whether an error is one of the moment: a lock, a full disk, a server that is away or in trouble itself."""
    from mlflow.exceptions import MlflowException
    from requests.exceptions import HTTPError, RequestException
    from sqlalchemy.exc import DBAPIError

    if _denying_status(error) is not None:
        return False
    if isinstance(error, HTTPError) and error.response is not None:
        return error.response.status_code >= _SERVER_ERROR or error.response.status_code == _TOO_MANY
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


def _denying_status(error: BaseException) -> int | None:
    """401 or 403 if an error says that its user may not do this; 401, too, of a database."""
    from mlflow.exceptions import MlflowException
    from requests.exceptions import HTTPError
    from sqlalchemy.exc import DBAPIError

    if isinstance(error, MlflowException):
        status: int = error.get_http_status_code()  # type: ignore[no-untyped-call]
    elif isinstance(error, HTTPError) and error.response is not None:
        status = error.response.status_code
    elif isinstance(error, DBAPIError) and any(word in str(error.orig) for word in _DENYING_WORDS):
        status = _UNKNOWN
    else:
        return None
    return status if status in (_UNKNOWN, _FORBIDDEN) else None


def _speaks_of_the_moment(text: str) -> bool:
    return "API request" in text or any(word in text.lower() for word in _PASSING_WORDS)


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
        client = _answering(MlflowClient(f"{_SQLITE}{path}"))
        analyze(path)
    return client


def _create_sqlite(path: Path) -> None:
    """Create a database under another name: one that is half created would be of no use for ever."""
    from mlflow import MlflowClient

    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    MlflowClient(f"{_SQLITE}{new}").search_experiments(max_results=1)
    new.rename(path)


def analyze(path: Path) -> None:
    """Tell SQLite's planner how its tables have grown; charts of many runs take seconds less."""
    with closing(sqlite3.connect(path, timeout=_WRITER_PATIENCE)) as database:
        database.execute("PRAGMA analysis_limit = 1000")
        database.execute("ANALYZE")
        database.commit()
