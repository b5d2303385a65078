"""Errors of tracking stores: which pass, which deny access, and what to say of them."""

from __future__ import annotations

import errno
import os
import sqlite3

from filelock import Timeout

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import is_server, sqlite_path

#: What databases say that can be used again in a while.
_PASSING_WORDS = ("locked", "busy", "full", "connection", "connect", "starting up", "shutting down", "i/o")
_SERVER_ERROR, _TOO_MANY = 500, 429
#: HTTP status for an unknown user, and for a user without the permission; what databases say to both.
_UNKNOWN, _FORBIDDEN = 401, 403
_DENYING_WORDS = ("authentication failed", "no password supplied", "permission denied", "pg_hba", '" does not exist')


class StoreUnavailableError(Exception):
    """A store cannot be used at the moment; it may be in a while."""


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
