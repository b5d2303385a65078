"""Connecting to an MLflow tracking store with MLflow's client."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rl_design_space.tracking.address import SQLITE, is_server, sqlite_path
from rl_design_space.tracking.mlflow_client import checked_client
from rl_design_space.tracking.sqlite_file import opened_sqlite
from rl_design_space.tracking.store_errors import as_tracking_error

if TYPE_CHECKING:
    from mlflow import MlflowClient


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
    path = sqlite_path(uri)
    try:
        if path:
            with opened_sqlite(path, creation_timeout, writer_timeout):
                return checked_client(f"{SQLITE}{path}")
        if is_server(uri):
            return checked_client(uri)
        from rl_design_space.tracking.database_engine import migrated

        return migrated(uri)
    except Exception as error:  # of MLflow, SQLAlchemy, Alembic, a driver, the file system
        raise as_tracking_error(uri, error) from error
