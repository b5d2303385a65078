"""Maintenance of a store: its status, damaged runs, and removing deleted runs for good."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from rl_design_space.errors import ConfigError
from rl_design_space.tracking.address import mlflow_uri, sqlite_path
from rl_design_space.tracking.backends import MlflowTracking
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.found_run import FoundRun, RunCounts
from rl_design_space.tracking.mlflow_client import configure_mlflow
from rl_design_space.tracking.queries import queries_of
from rl_design_space.tracking.read_only import not_writable, unwritable
from rl_design_space.tracking.run_files import DamagedFileError
from rl_design_space.tracking.selection import named
from rl_design_space.tracking.spool import Spool, is_point
from rl_design_space.tracking.sqlite_file import analyze
from rl_design_space.tracking.store_errors import as_tracking_error, first_line, is_transient

#: Seconds to wait for other processes that write to the database.
_PATIENCE = 30


@dataclass(frozen=True)
class StoreStatus:
    """What a store and its spool hold.

    Attributes:
        runs: numbers of runs of the experiment that holds the design points.
        pending: number of pending records.
        pending_points: number of those that are records of points.
        quarantined: files of the quarantined records.
        sizes: bytes on this disk by what they are used for.
    """

    runs: RunCounts
    pending: int
    pending_points: int
    quarantined: list[Path]
    sizes: Mapping[str, int]


@dataclass(frozen=True)
class Compaction:
    """What compacting a database has done.

    Attributes:
        removed: number of deleted runs that were removed for good.
        before: size of the database in bytes.
        after: size of the database in bytes.
    """

    removed: int
    before: int
    after: int


def status(options: MlflowTracking) -> StoreStatus:
    """Return what a store and its spool hold.

    Raises:
        ConfigError: there is no store.
        StoreUnavailableError: the store cannot be reached at the moment.
    """
    database = sqlite_path(options.uri)
    if database and not database.exists() and not Path(options.spool).exists():
        raise ConfigError.at("tracking.uri", options.uri, "no run has been recorded there yet; outputs=DIR looks there")
    runs = queries_of(options.address).counts()
    spool = Spool.of(Path(options.spool), options.address, create=False)
    pending = spool.pending() if spool.folder.exists() else []
    return StoreStatus(runs, len(pending), sum(map(is_point, pending)), spool.quarantined(), _sizes(options))


def compact(options: MlflowTracking) -> Compaction:
    """Remove deleted runs and their files with MLflow, release the space, and update the query planner's statistics.

    Raises:
        ConfigError: the store is not a SQLite database on this machine, or another process is using it.
    """
    database = sqlite_path(options.uri)
    if database is None:
        raise ConfigError.at("tracking.uri", options.uri, "only a SQLite database is compacted; for others: mlflow gc")
    if not database.exists():
        raise ConfigError.at("tracking.uri", options.uri, "no run has been recorded there yet")
    if reason := unwritable(database):
        raise not_writable(database.parent, reason)
    before, deleted = _size([database]), queries_of(options.address).counts().deleted
    configure_mlflow()
    collector = [sys.executable, "-m", "mlflow", "gc"]
    uri = mlflow_uri(options.address.uri)
    collector += ["--backend-store-uri", uri, "--tracking-uri", uri]
    collected = subprocess.run(collector, capture_output=True, text=True, check=False)
    if collected.returncode:
        raise ConfigError(f"{database}: mlflow gc failed: {collected.stderr.strip().splitlines()[-1]}")
    try:
        with closing(sqlite3.connect(database, timeout=_PATIENCE, isolation_level=None)) as connection:
            connection.execute("VACUUM")
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        analyze(database)
    except sqlite3.Error as error:
        advice = "; try again when no other process uses it" if is_transient(error) else ""
        raise ConfigError(f"{database}: cannot be compacted: {first_line(error)}{advice}") from error
    return Compaction(deleted, before, _size([database]))


def complete_runs(options: MlflowTracking) -> list[FoundRun]:
    """Return the complete runs of a store.

    Raises:
        ConfigError: there is no store.
        StoreUnavailableError: the store cannot be reached at the moment.
    """
    return options.reader().runs()


def check(options: MlflowTracking, runs: Iterable[FoundRun]) -> Iterator[DamagedFileError | None]:
    """Read the files of runs; yield what is wrong with each run, or None.

    Raises:
        StoreUnavailableError: the store cannot be reached at the moment.
    """
    reader = options.reader()
    for run in runs:
        try:
            reader.check(run)
        except DamagedFileError as error:
            yield error
        else:
            yield None


def forget(options: MlflowTracking, run_ids: Iterable[str]) -> list[FoundRun]:
    """Delete runs in MLflow, which can restore them, so that their points count as missing; return the runs.

    Args:
        options: of the store.
        run_ids: ids of complete runs, or beginnings of them.

    Raises:
        ConfigError: there is no such run, or several; nothing was deleted then.
        StoreUnavailableError: the store cannot be reached at the moment.
    """
    every = complete_runs(options)
    runs = {run.run_id: run for run in (named(every, run_id) for run_id in run_ids)}
    client = connect(options.address.uri) if runs else None
    try:
        for run_id in runs:
            assert client is not None
            client.delete_run(run_id)
    except Exception as error:
        raise as_tracking_error(options.address.uri, error) from error
    return list(runs.values())


def _sizes(options: MlflowTracking) -> dict[str, int]:
    sizes = {}
    if database := sqlite_path(options.uri):
        sizes["database"] = _size([database, database.with_name(f"{database.name}-wal")])
        sizes["artifacts"] = _size((database.parent / "artifacts").rglob("*"))
    sizes["spool"] = _size(Path(options.spool).rglob("*"))
    return sizes


def _size(files: Iterable[Path]) -> int:
    return sum(path.stat().st_size for path in files if path.is_file())
