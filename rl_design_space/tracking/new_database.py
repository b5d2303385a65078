"""Creating SQLite databases: MLflow takes seconds for one, so that an empty one is kept and copied."""

from __future__ import annotations

import os
import sqlite3
import time
from contextlib import closing, suppress
from importlib.metadata import version
from pathlib import Path
from uuid import uuid4

from rl_design_space.tracking.address import SQLITE
from rl_design_space.tracking.mlflow_client import checked_client


def create_database(path: Path, kept: Path | None = None) -> None:
    """Create an empty database; it is there completely or not at all.

    Args:
        path: of the database, whose folder exists.
        kept: folder of empty databases, one for each version of MLflow; one in the user's folder of caches if None.
    """
    template = (kept or _cache()) / f"mlflow-{version('mlflow')}.db"
    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    if not _copied(template, new):
        checked_client(f"{SQLITE}{new}")
        with suppress(OSError, sqlite3.Error):  # the folder cannot be written to
            _keep(new, template)
    new.rename(path)


def _copied(template: Path, path: Path) -> bool:
    """Copy a database as if it had been created in this place at this moment; return False if it cannot be used."""
    try:
        _copy(template, path)
        with closing(sqlite3.connect(path)) as database:
            if database.execute("PRAGMA integrity_check").fetchone() != ("ok",):
                raise sqlite3.DatabaseError(f"{template} is damaged")
            now = int(time.time() * 1000)
            update = "UPDATE experiments SET artifact_location = ?, creation_time = ?, last_update_time = ?"
            database.execute(update, (str(Path("mlruns/0").absolute()), now, now))
            database.commit()
    except (OSError, sqlite3.Error):
        path.unlink(missing_ok=True)
        return False
    return True


def _keep(database: Path, template: Path) -> None:
    template.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    unfinished = template.with_name(f".{template.name}.{uuid4().hex}")
    try:
        _copy(database, unfinished)
        unfinished.replace(template)
    finally:
        unfinished.unlink(missing_ok=True)


def _copy(source: Path, target: Path) -> None:
    """Copy a database with all that its log holds."""
    with (
        closing(sqlite3.connect(f"{source.absolute().as_uri()}?mode=ro", uri=True)) as one,
        closing(sqlite3.connect(target)) as other,
    ):
        one.backup(other)
        other.execute("PRAGMA journal_mode = DELETE")  # without a log beside it


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "rl-design-space"
