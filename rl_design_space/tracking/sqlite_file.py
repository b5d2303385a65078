"""SQLite files that hold an MLflow database."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from filelock import FileLock

from rl_design_space.tracking.new_database import create_database


@contextmanager
def opened_sqlite(path: Path, creation_timeout: float, writer_timeout: float) -> Iterator[None]:
    """Create a database if missing, and let the caller migrate it, under a lock: two at once would corrupt it.

    Args:
        path: of the database.
        creation_timeout: seconds to wait for another process that is creating it.
        writer_timeout: seconds to wait for another process that is writing to it.

    Raises:
        Exception: of the file system, SQLite or MLflow.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(f"{path}.lock", timeout=creation_timeout):
        if not path.exists():
            create_database(path)
        with closing(sqlite3.connect(path, timeout=writer_timeout)) as database:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("BEGIN IMMEDIATE")
            database.rollback()
        yield
        analyze(path, writer_timeout)


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
