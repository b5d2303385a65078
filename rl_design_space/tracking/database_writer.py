"""Writing records directly into MLflow's database: a run is in it completely or not at all."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cached_property
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import text

from rl_design_space.tracking import values
from rl_design_space.tracking.address import sqlite_path
from rl_design_space.tracking.artifacts import artifacts_folder, is_local
from rl_design_space.tracking.content import content_of, sweep_note
from rl_design_space.tracking.database_runs import DatabaseRuns, Experiment, NewRun
from rl_design_space.tracking.locks import PointLocks, lock_number
from rl_design_space.tracking.record import ended_at, fingerprint_of
from rl_design_space.tracking.spool import CLOSE, OPEN, POINT, STUDIES, TIDY, Record, Spool
from rl_design_space.tracking.stale import DEAD, RunningRun
from rl_design_space.tracking.store_errors import DeletedExperimentError, StoreUnavailableError
from rl_design_space.tracking.tags import (
    FINGERPRINT_TAG,
    INCOMPLETE_TAG,
    NOTE_TAG,
    PRECISION_TAG,
    SPOOL_TAG,
    SWEEP_TAG,
    of_any_command,
)

if TYPE_CHECKING:
    from sqlalchemy import Engine


class DatabaseWriter:
    """Writes the records of a spool in transactions, see `StoreWriter`.

    A point that the database has already, from whatever process or machine, is not written again: a transaction looks
    for it, and no other one can write the same point at that time.

    Args:
        engine: of a database whose schema is one of `database_tables.REVISIONS`.
        spool: where the records are.
        locks: of the points of the store.
    """

    batch = 50

    def __init__(self, engine: Engine, spool: Spool, locks: PointLocks) -> None:
        self._engine = engine
        self._spool = spool
        self._locks = locks
        self._identity = spool.identity
        self._path = sqlite_path(spool.address.uri)
        self._opened = _inode(self._path)

    def has_local_artifacts(self) -> bool:
        """Create the experiments if missing; return whether the artifacts of both are files of this machine.

        Raises:
            Exception: of the database.
        """
        with self._transaction(["experiments"]) as batch:
            return all(is_local(experiment.artifacts) for experiment in batch.usable)

    def write(self, records: Sequence[Record]) -> None:
        """Write records in this order, all or none."""
        runs = {record.key: _point_run(record, self._identity) for record in records if record.kind == POINT}
        keys = {key for record in records for key in (record.key, fingerprint_of(record))}
        with self._transaction(sorted(keys)) as batch:
            for kind, same in groupby(records, lambda record: record.kind):
                if kind == POINT:
                    batch.add_points([runs[record.key] for record in same])
                else:
                    for record in same:
                        self._writers(batch)[kind](record)
            for record in records:
                if record.kind == POINT:
                    for key in {record.key, fingerprint_of(record)}:
                        self._locks.add_to_journal(key)

    def close_stale_runs(self) -> None:
        """Mark as KILLED the RUNNING runs that no process will finish.

        Those are the runs of points that this spool has begun, by way of MLflow's client, and sweeps that have died.
        """
        with self._transaction(["stale"]) as batch:
            batch.close_stale_runs()

    def close(self) -> None:
        """Close connections."""
        self._engine.dispose()

    def _writers(self, batch: _Batch) -> Mapping[str, Callable[[Record], None]]:
        return {
            OPEN: batch.open_sweep,
            STUDIES: batch.add_studies,
            CLOSE: batch.close_sweep,
            TIDY: lambda record: batch.close_stale_runs(),
        }

    @contextmanager
    def _transaction(self, keys: Sequence[str]) -> Iterator[_Batch]:
        """Begin a transaction; none that has a key in common can be open at the same time.

        Raises:
            StoreUnavailableError: the database is not that which was opened; it was removed or replaced.
        """
        if _inode(self._path) != self._opened:
            raise StoreUnavailableError(f"{self._path}: was removed or replaced")
        with self._engine.begin() as connection:
            if connection.dialect.name == "postgresql":
                # All transactions lock in the same order. SQLite has one transaction at a time.
                numbers = sorted(map(lock_number, keys))
                locked = text("select pg_advisory_xact_lock(number) from unnest(cast(:numbers as bigint[])) number")
                connection.execute(locked, {"numbers": numbers})
            yield _Batch(DatabaseRuns(connection), self._spool, self._locks)


class _Batch:
    """What records of each kind do in a transaction."""

    def __init__(self, runs: DatabaseRuns, spool: Spool, locks: PointLocks) -> None:
        self._runs = runs
        self._spool = spool
        self._locks = locks
        self._address = spool.address

    @cached_property
    def points(self) -> Experiment:
        """The experiment of the design points."""
        return self._experiment("experiment", self._address.experiment)

    @cached_property
    def sweeps(self) -> Experiment:
        """The experiment of the sweeps."""
        return self._experiment("sweeps", self._address.sweeps)

    @property
    def usable(self) -> list[Experiment]:
        """Those of both experiments that were not deleted."""
        found = []
        for name in ("points", "sweeps"):
            with suppress(DeletedExperimentError):
                found.append(getattr(self, name))
        return found

    def add_points(self, runs: Iterable[NewRun]) -> None:
        """Add the runs of points; a point that is there gets the tags of its studies and precisions."""
        new: dict[str, NewRun] = {}
        for run in runs:
            first = new.setdefault(run.tags[FINGERPRINT_TAG], run)
            new[run.tags[FINGERPRINT_TAG]] = replace(first, tags={**of_any_command(run.tags), **first.tags})
        known = self._runs.find(self.points, FINGERPRINT_TAG, list(new), finished=True)
        for fingerprint, run_id in known.items():
            self._runs.set_tags(run_id, of_any_command(new[fingerprint].tags))
        # Written by this record before, and deleted since.
        deleted = self._runs.existing([run.run_id for run in new.values()])
        missing = [run for fingerprint, run in new.items() if fingerprint not in known and run.run_id not in deleted]
        self._runs.add(self.points, missing)

    def add_studies(self, record: Record) -> None:
        """Add tags of studies to runs of points."""
        tags: Mapping[str, Mapping[str, str]] = record.content["tags"]
        known = self._runs.find(self.points, FINGERPRINT_TAG, list(tags), finished=True)
        asked = {f"{PRECISION_TAG}.{fingerprint}": fingerprint for fingerprint in tags.keys() - known.keys()}
        found = self._runs.having(self.points, list(asked))
        for fingerprint, run_id in [*known.items(), *((asked[name], run_id) for name, run_id in found.items())]:
            self._runs.set_tags(run_id, tags[fingerprint])

    def open_sweep(self, record: Record) -> None:
        """Add the RUNNING summary run of a sweep, and the views of its experiments."""
        run_id = self._sweep_run(record)
        self._kill_if_stale(run_id, RunningRun(self._spool.identity, "", record.key))
        self._runs.set_experiment_tags(self.points, record.content["views"])
        self._runs.set_experiment_tags(self.sweeps, record.content["sweep_views"])

    def close_sweep(self, record: Record) -> None:
        """End the summary run of a sweep."""
        content, run_id = record.content, self._sweep_run(record)
        metrics = [(name, value, step) for name, value, step in content["metrics"]]
        self._runs.set_tags(run_id, {NOTE_TAG: sweep_note(record, run_id)})
        self._runs.remove_tag(run_id, INCOMPLETE_TAG)  # of another process that took this sweep for dead
        self._runs.end(run_id, content["status"], content["ended"], metrics, record.files)

    def close_stale_runs(self) -> None:
        """Mark as KILLED the RUNNING runs that no process will finish."""
        for run_id, tags in self._runs.running(self.usable).items():
            self._kill_if_stale(run_id, RunningRun.of(tags))

    def _kill_if_stale(self, run_id: str, run: RunningRun) -> None:
        if run.is_stale(self._spool, self._locks):
            self._runs.set_tags(run_id, {INCOMPLETE_TAG: DEAD})
            self._runs.end(run_id, "KILLED", _now())

    def _experiment(self, key: str, name: str) -> Experiment:
        folder = artifacts_folder(self._address, self._spool.folder.parent)
        assert folder  # of a database
        return self._runs.experiment(key, name, folder)

    def _sweep_run(self, record: Record) -> str:
        """Return the id of the summary run of a sweep, which is added if missing."""
        if found := self._runs.find(self.sweeps, SWEEP_TAG, [record.key], finished=False):
            return found[record.key]
        content = record.content
        tags = {**content["tags"], SWEEP_TAG: record.key, SPOOL_TAG: self._spool.identity}
        run = NewRun(
            run_id=record.digest[:32],
            name=values.run_name(content["name"]),
            started=content["started"],
            status="RUNNING",
            ended=None,
            tags=tags,
            artifacts=record.files,
        )
        self._runs.add(self.sweeps, [run])
        return run.run_id


def _point_run(record: Record, spool: str) -> NewRun:
    run_id = record.digest[:32]
    content, run_content = record.content, content_of(record, run_id)
    own = {FINGERPRINT_TAG: fingerprint_of(record), SPOOL_TAG: spool, NOTE_TAG: run_content.note}
    return NewRun(
        run_id=run_id,
        name=values.run_name(content["name"]),
        started=content["started"],
        status="FINISHED",
        ended=ended_at(record),
        tags={**content["tags"], **own},
        params=content["params"],
        metrics=run_content.metrics,
        artifacts=run_content.artifacts,
    )


def _inode(path: Path | None) -> int:
    """Return the number that identifies a file; 0 if there is none."""
    try:
        return path.stat().st_ino if path else 0
    except OSError:
        return 0


def _now() -> int:
    """Return milliseconds since 1970."""
    return int(time.time() * 1000)
