"""A frame of all runs is kept beside a SQLite database, for as long as the database has not changed."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space._version import __version__
from rl_design_space.tracking.address import StoreAddress, sqlite_path

if TYPE_CHECKING:
    import pandas as pd

#: Nanoseconds within which a file can change without its time telling: file systems count in steps.
_RACY = 2_000_000_000


def cached(address: StoreAddress, read: Callable[[], pd.DataFrame]) -> pd.DataFrame:
    """What `read` gives; from a file if the database is as it was when that was written.

    Every change of a SQLite database changes the time or the size of one of its two files. A change that was so recent
    when it was read that another one might bear the same time is not relied upon: then nothing is kept. Other stores
    cannot be asked whether they have changed, so nothing is kept of them.
    """
    database = sqlite_path(address.uri)
    state = _state(database, address) if database else None
    if database is None or state is None:
        return read()
    import pandas as pd

    file = cache_file(database)
    with suppress(OSError, ValueError, KeyError):  # there is none, or it was not written by us
        frame = pd.read_parquet(file)
        if frame.attrs["state"] == state:
            return frame
    frame = read()
    if _state(database, address) == state:
        new = file.with_name(f".{file.name}.new")
        with suppress(OSError):  # of a folder that may only be read: then without
            frame.attrs["state"] = state
            frame.to_parquet(new)
            new.replace(file)
    return frame


def cache_file(database: Path) -> Path:
    """Where the frame of a database's runs is kept."""
    return database.with_name(f"{database.name}.runs.parquet")


def _state(database: Path, address: StoreAddress) -> str | None:
    """The state of a database, by its files; None if it has changed just now."""
    parts = [__version__, address.experiment]
    for file in (database, database.with_name(f"{database.name}-wal")):
        try:
            about = file.stat()
        except FileNotFoundError:
            continue
        if not about.st_size:  # readers make and remove an empty log, too
            continue
        if time.time_ns() - about.st_mtime_ns < _RACY:
            return None
        parts.append(f"{about.st_ino} {about.st_size} {about.st_mtime_ns}")
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()
