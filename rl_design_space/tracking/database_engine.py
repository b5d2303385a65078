"""Engines of databases that are written to directly."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import URL, Connection, Engine, NullPool, create_engine, event, func, inspect, select, text

from rl_design_space.tracking import database_tables
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.mlflow_client import checked_client
from rl_design_space.tracking.sqlite_file import opened_sqlite
from rl_design_space.tracking.store_errors import as_tracking_error

if TYPE_CHECKING:
    from mlflow import MlflowClient

#: Id of the advisory lock in PostgreSQL under which tables are created.
_CREATION_LOCK = 0x726C2D6473


def open_known_database(uri: str, *, creation_timeout: float = 120, writer_timeout: float = 5) -> Engine | None:
    """Return an engine for a database whose schema is known; None for any other store.

    MLflow, whose import takes seconds, is needed for a database that does not exist yet. Transactions of SQLite are
    exclusive from their beginning.

    Args:
        uri: URI of the store.
        creation_timeout: seconds to wait for another process that is creating the SQLite database.
        writer_timeout: seconds to wait for another process that is writing to it.

    Raises:
        ConfigError: the database cannot be used.
        StoreUnavailableError: the database cannot be reached or written to at the moment.
    """
    path = sqlite_path(uri)
    if not path and not uri.startswith("postgresql"):
        return None
    try:
        if path:
            with opened_sqlite(path, creation_timeout, writer_timeout):
                return _of_known_schema(_sqlite_engine(path, writer_timeout))
        engine = create_engine(uri)
        if not inspect(engine).has_table("alembic_version"):
            migrated(uri)
        return _of_known_schema(engine)
    except Exception as error:  # of SQLAlchemy, MLflow, Alembic, a driver, the file system
        raise as_tracking_error(uri, error) from error


def migrated(uri: str) -> MlflowClient:
    """Connect once before MLflow does, which retries for an hour; lock while it creates and migrates the tables."""
    engine = create_engine(uri, poolclass=NullPool)
    with engine.connect() as connection:
        if engine.dialect.name == "postgresql":
            connection.execute(select(func.pg_advisory_lock(_CREATION_LOCK)))
        return checked_client(uri)


def _sqlite_engine(path: Path, writer_timeout: float) -> Engine:
    """Return an engine whose transactions lock the database when they begin, as SQLAlchemy's documentation shows."""
    engine = create_engine(URL.create("sqlite", database=str(path)), connect_args={"timeout": writer_timeout})

    @event.listens_for(engine, "connect")
    def _connected(connection: sqlite3.Connection, record: object) -> None:
        connection.isolation_level = None  # the driver begins no transactions of its own

    @event.listens_for(engine, "begin")
    def _begun(connection: Connection) -> None:
        connection.exec_driver_sql("BEGIN IMMEDIATE")

    return engine


def _of_known_schema(engine: Engine) -> Engine | None:
    with engine.connect() as connection:
        has_versions = inspect(connection).has_table("alembic_version")
        revisions = connection.scalars(text("select version_num from alembic_version")).all() if has_versions else []
    return engine if set(revisions) & database_tables.REVISIONS else None
