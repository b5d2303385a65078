"""The state of a store, and making it small again."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.filesize import decimal
from rich.markup import escape
from rich.table import Table

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.backends import MlflowTracking
from rl_design_space.tracking.connection import analyze, configure_mlflow
from rl_design_space.tracking.queries import Counted, source_of
from rl_design_space.tracking.spool import Spool, point_name
from rl_design_space.tracking.store_errors import passes, reason

#: Seconds to wait for others who write to the database.
_PATIENCE = 30


def status_table(options: MlflowTracking) -> Table:
    """What a store has, how large it is, and what does not belong there.

    Raises:
        ConfigError: there is no store.
        StoreUnavailableError: it cannot be reached at the moment.
    """
    counted = source_of(options.address).counted()
    spool = Spool.of(Path(options.spool), options.address)
    table = Table(box=SIMPLE_HEAD, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    table.add_row("store", escape(options.address.uri))
    table.add_row("points", f"{counted.finished:,} complete in experiment {options.experiment!r}")
    table.add_row("incomplete", _incomplete(counted))
    table.add_row("deleted", f"{counted.deleted:,} runs; `rl-design-space store compact` removes them for good")
    waiting = spool.waiting()
    points = sum(name.startswith(point_name("")[:2]) for name in waiting)
    table.add_row("unsynced", f"{points:,} points, {len(waiting):,} records in all" if waiting else "nothing")
    aside = spool.aside()
    table.add_row("set aside", f"{len(aside):,} records, in {escape(str(aside[0].parent))}" if aside else "nothing")
    for what, size in _sizes(options).items():
        table.add_row(what, decimal(size))
    return table


def compact(options: MlflowTracking) -> str:
    """Have MLflow remove deleted runs with their files; give back the room, and renew what SQLite knows of its tables.

    Returns:
        What was done, for people.

    Raises:
        ConfigError: there is no such database, it is not a file of this machine, or somebody else keeps it busy.
    """
    database = sqlite_path(options.uri)
    if database is None:
        raise ConfigError.at("tracking.uri", options.uri, "only a SQLite database is compacted; for others: mlflow gc")
    if not database.exists():
        raise ConfigError.at("tracking.uri", options.uri, "no run has been recorded there yet")
    before, deleted = _size([database]), source_of(options.address).counted().deleted
    configure_mlflow()
    collector = [sys.executable, "-m", "mlflow", "gc"]
    collector += ["--backend-store-uri", options.address.uri, "--tracking-uri", options.address.uri]
    collected = subprocess.run(collector, capture_output=True, text=True, check=False)
    if collected.returncode:
        raise ConfigError(f"{database}: mlflow gc failed: {collected.stderr.strip().splitlines()[-1]}")
    try:
        with closing(sqlite3.connect(database, timeout=_PATIENCE, isolation_level=None)) as connection:
            connection.execute("VACUUM")
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        analyze(database)
    except sqlite3.Error as error:
        advice = "; try again when nothing else uses it" if passes(error) else ""
        raise ConfigError(f"{database}: cannot be compacted: {reason(error)}{advice}") from error
    return f"{deleted:,} deleted runs removed; the database was {decimal(before)}, is {decimal(_size([database]))}"


def _incomplete(counted: Counted) -> str:
    others = [f"{count:,} {status}" for status, count in sorted(counted.others.items())]
    return ", ".join(others) or "none"


def _sizes(options: MlflowTracking) -> dict[str, int]:
    """Bytes on this disk, by what they are."""
    sizes = {}
    if database := sqlite_path(options.uri):
        sizes["database"] = _size([database, database.with_name(f"{database.name}-wal")])
        sizes["artifacts"] = _size((database.parent / "artifacts").rglob("*"))
    sizes["spool"] = _size(Path(options.spool).rglob("*"))
    return sizes


def _size(files: Iterable[Path]) -> int:
    return sum(path.stat().st_size for path in files if path.is_file())
