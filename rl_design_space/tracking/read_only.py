"""Reading SQLite databases that cannot be written to: on a read-only medium, or in another user's folder."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from rl_design_space._paths import why_unwritable
from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import mlflow_uri, sqlite_path

if TYPE_CHECKING:
    from sqlalchemy import Engine


def reading_engine(uri: str) -> Engine:
    """Return an engine that reads a database."""
    import sqlalchemy

    path = sqlite_path(uri)
    if path is None or not unwritable(path):
        return sqlalchemy.create_engine(mlflow_uri(uri))
    # A connection for each transaction: what is open as immutable does not notice that its owner begins to write.
    return sqlalchemy.create_engine("sqlite://", creator=lambda: opened(path), poolclass=sqlalchemy.NullPool)


def opened(path: Path) -> sqlite3.Connection:
    """Open a database that cannot be written to.

    In the mode of MLflow's databases, readers share an index in a file beside the database, which cannot be created
    here. None is needed if no other process writes; if one does, its index is read. What a process that was killed has
    left in the write-ahead log can be read in a copy only.
    """
    log = path.with_name(f"{path.name}-wal")
    if not log.exists():
        return _connected(path, "mode=ro&immutable=1")
    try:
        return _connected(path, "mode=ro")
    except sqlite3.OperationalError:
        return _copied(path) if log.stat().st_size else _connected(path, "mode=ro&immutable=1")


def unwritable(path: Path) -> str:
    """Return why a database cannot be written to; empty if it can."""
    return why_unwritable(path) or why_unwritable(path.parent)


def not_writable(folder: Path, reason: str) -> ConfigError:
    """Return the error for a folder that has to be written to, and cannot be."""
    remedy = "outputs=DIR or tracking.uri=URI names another place, such as a copy of this one"
    return ConfigError(f"{folder}: cannot be written to ({reason}); {remedy}")


@contextmanager
def writable_copy(path: Path) -> Iterator[Path]:
    """Copy a database into a temporary folder, which is removed when the block ends."""
    with TemporaryDirectory(prefix="rl-design-space-") as folder:
        place = Path(folder) / path.name
        with closing(opened(path)) as source, closing(sqlite3.connect(place)) as target:
            source.backup(target)
        yield place


def _connected(path: Path, mode: str) -> sqlite3.Connection:
    connection = sqlite3.connect(f"{path.as_uri()}?{mode}", uri=True, check_same_thread=False)
    try:
        connection.execute("select 1 from sqlite_master")
    except sqlite3.Error:
        connection.close()
        raise
    return connection


def _copied(path: Path) -> sqlite3.Connection:
    """Return a copy in memory of a database and its write-ahead log."""
    memory = sqlite3.connect(":memory:", check_same_thread=False)
    with TemporaryDirectory(prefix="rl-design-space-") as folder:
        place = Path(folder) / path.name
        for suffix in ("", "-wal"):
            shutil.copyfile(f"{path}{suffix}", f"{place}{suffix}")
        with closing(sqlite3.connect(place)) as source:
            source.backup(memory)
    return memory
