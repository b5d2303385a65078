"""Errors of tracking stores: which are transient, which are about access, and how they are reported."""

from __future__ import annotations

import errno
import os
import shlex
import sqlite3
import sys
from typing import Any

from filelock import Timeout

from rl_design_space._secrets import without_secrets
from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import StoreAddress, is_server, sqlite_path
from rl_design_space.tracking.read_only import not_writable, unwritable

#: Words in the messages of databases whose trouble is transient.
_TRANSIENT_WORDS = ("locked", "busy", "full", "connection", "connect", "starting up", "shutting down", "i/o")
_SERVER_ERROR, _TOO_MANY = 500, 429
#: HTTP status for an unknown user, and for a user without permission; words in the messages of databases for either.
_UNKNOWN, _FORBIDDEN = 401, 403
_ACCESS_WORDS = ("authentication failed", "no password supplied", "permission denied", "pg_hba", '" does not exist')


class StoreUnavailableError(Exception):
    """The store cannot be used at the moment; trying again later may succeed.

    Passwords and tokens in the message are left out.

    Args:
        message: what is wrong.
    """

    def __init__(self, message: str) -> None:
        super().__init__(without_secrets(message))


def as_tracking_error(uri: str, error: Exception) -> ConfigError | StoreUnavailableError:
    """Translate an exception of a store, a driver or the file system into one of this package."""
    if isinstance(error, (ConfigError, StoreUnavailableError)):
        return error
    if denied := access_error(uri, error):
        return denied
    if is_transient(error):
        return StoreUnavailableError(f"{uri}: {first_line(error)}")
    # However little memory makes itself felt: a shared library that cannot be mapped is an ImportError without a name.
    if isinstance(error, (MemoryError, SystemError)) or (isinstance(error, ImportError) and not error.name):
        return ConfigError(f"MLflow cannot be loaded, perhaps for want of memory: {first_line(error)}")
    path = sqlite_path(uri)
    if path and (reason := unwritable(path)) and _is_about_writing(error):
        return not_writable(path.parent, reason)
    return ConfigError.at("tracking.uri", uri, f"cannot be used: {first_line(error)}")


def access_error(uri: str, error: BaseException) -> ConfigError | None:
    """Return what to report if a store has denied access; None if that is not what went wrong."""
    status = _access_status(error)
    if status is None:
        return None
    if not is_server(uri):
        where = "" if sqlite_path(uri) else "; a password belongs in the environment, PGPASSWORD for PostgreSQL"
        return ConfigError.at("tracking.uri", uri, f"access denied: {first_line(error)}{where}")
    user = os.environ.get("MLFLOW_TRACKING_USERNAME")
    if status == _FORBIDDEN:
        who = f"user {user}" if user else "you"
        return ConfigError.at("tracking.uri", uri, f"{who} may not write or read there; its administrator can allow it")
    expected = (
        f"the server does not accept user {user} with the password in MLFLOW_TRACKING_PASSWORD"
        if user
        else "the server requires a login: set MLFLOW_TRACKING_USERNAME and MLFLOW_TRACKING_PASSWORD in the environment"
    )
    return ConfigError.at("tracking.uri", uri, expected)


def is_transient(error: Any) -> bool:
    """Return whether the error is transient: a lock, a full disk, a server that is away or reports an error itself."""
    if _access_status(error) is not None:
        return False
    if _is(error, "requests.exceptions", "HTTPError") and error.response is not None:
        status: int = error.response.status_code
        return status >= _SERVER_ERROR or status == _TOO_MANY
    if isinstance(error, (StoreUnavailableError, Timeout, ConnectionError)):
        return True
    if _is(error, "requests.exceptions", "RequestException"):
        return True
    if _is(error, "sqlalchemy.exc", "DBAPIError") or isinstance(error, sqlite3.OperationalError):
        return any(word in str(error).lower() for word in _TRANSIENT_WORDS)
    if isinstance(error, OSError):
        return error.errno in (errno.ENOSPC, errno.EDQUOT)
    if _is(error, "mlflow.exceptions", "MlflowException"):
        cause = error.__cause__ or error.__context__
        if cause is not None and is_transient(cause):
            return True
        # A server answers so when its own database is away; a database raises it for errors of all kinds.
        status = error.get_http_status_code()
        return status >= _SERVER_ERROR and _has_transient_words(str(error))
    return False


def first_line(error: BaseException) -> str:
    """Return the message of an error in one line."""
    if isinstance(error, Timeout):
        return "another process has been creating it for minutes"
    line = next(iter(str(error).strip().splitlines()), type(error).__name__)
    return line.partition(" with exception ")[0]


class DeletedExperimentError(ConfigError):
    """An experiment that was deleted; see `deleted_experiment`."""


def deleted_experiment(key: str, name: str, uri: str, experiment: object) -> ConfigError:
    """Return the error for an experiment that was deleted.

    Args:
        key: the setting that names it.
        name: of the experiment.
        uri: of the store.
        experiment: its id.
    """
    restore = f"MLFLOW_TRACKING_URI={shlex.quote(uri)} mlflow experiments restore --experiment-id {experiment}"
    expected = f"was deleted in this store; use another name, or restore it with: {restore}"
    return DeletedExperimentError.at(f"tracking.{key}", name, expected)


def missing_experiment(address: StoreAddress) -> ConfigError:
    """Return the error for a store without the experiment of the design points."""
    return ConfigError.at("tracking.experiment", address.experiment, f"there is no such experiment in {address.uri}")


def _is_about_writing(error: Exception) -> bool:
    if isinstance(error, OSError):
        return error.errno in (errno.EROFS, errno.EACCES)
    return any(words in str(error) for words in ("readonly database", "unable to open database file"))


def _access_status(error: Any) -> int | None:
    """Return 401 or 403 if an error says that access was denied, 401 for databases; None for any other error."""
    if _is(error, "mlflow.exceptions", "MlflowException"):
        status: int = error.get_http_status_code()
    elif _is(error, "requests.exceptions", "HTTPError") and error.response is not None:
        status = error.response.status_code
    elif _is(error, "sqlalchemy.exc", "DBAPIError") and any(word in str(error.orig) for word in _ACCESS_WORDS):
        status = _UNKNOWN
    else:
        return None
    return status if status in (_UNKNOWN, _FORBIDDEN) else None


def _is(error: Any, module: str, name: str) -> bool:
    """Return whether an error is of a class, without importing its module: MLflow's takes seconds."""
    return module in sys.modules and isinstance(error, getattr(sys.modules[module], name))


def _has_transient_words(text: str) -> bool:
    return "API request" in text or any(word in text.lower() for word in _TRANSIENT_WORDS)
