"""Databases that cannot be written to, in whatever state the last process has left them, and stores that were moved."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.tracking import read_only
from rl_design_space.tracking.read_only import opened, writable_copy
from rl_design_space.tracking.tracker import StoredRun
from tests.tracking.stores import learned, options, record, tracker_at

ROWS = "select number from numbers"


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """A database whose only transaction is in the write-ahead log, as a process that was killed leaves it."""
    source, path = tmp_path / "source.db", tmp_path / "it's?50%.db"
    with closing(sqlite3.connect(source, isolation_level=None)) as connection:
        for statement in (
            "pragma journal_mode = wal",
            "create table numbers (number)",
            "insert into numbers values (7)",
        ):
            connection.execute(statement)
        for suffix in ("", "-wal"):
            shutil.copyfile(f"{source}{suffix}", f"{path}{suffix}")
    return path


@pytest.fixture
def no_index(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have SQLite fail as where the index of the log is missing and cannot be created."""
    connected = read_only._connected

    def refusing(path: Path, mode: str) -> sqlite3.Connection:
        return connected(path if "immutable" in mode else path / "none", mode)

    monkeypatch.setattr(read_only, "_connected", refusing)


def test_what_is_in_the_log_is_read(written: Path, no_index: None):
    before = sorted(written.parent.iterdir())
    with closing(opened(written)) as connection:
        assert connection.execute(ROWS).fetchall() == [(7,)]
    with writable_copy(written) as copy, closing(sqlite3.connect(copy)) as connection:
        connection.execute("insert into numbers values (8)")
    assert not copy.exists()
    assert sorted(written.parent.iterdir()) == before


@pytest.mark.parametrize("log", ["missing", "empty"])
def test_a_database_that_was_closed_is_read_without_an_index(log: str, written: Path, no_index: None):
    with closing(sqlite3.connect(written)) as connection:
        connection.execute(ROWS)  # the last one to close it writes the log into it
    written.with_name(f"{written.name}-wal").unlink(missing_ok=True)
    if log == "empty":
        written.with_name(f"{written.name}-wal").touch()
    before = sorted(written.parent.iterdir())
    with closing(opened(written)) as connection:
        assert connection.execute(ROWS).fetchall() == [(7,)]
    assert sorted(written.parent.iterdir()) == before


def test_a_writer_that_lives_is_read_through_its_index(written: Path):
    with closing(sqlite3.connect(written, isolation_level=None)) as writer:
        writer.execute("insert into numbers values (8)")
        with closing(opened(written)) as connection:
            writer.execute("insert into numbers values (9)")
            assert connection.execute(ROWS).fetchall() == [(7,), (8,), (9,)]


def test_a_store_that_was_moved_is_read_with_its_files(database: Path, tmp_path: Path):
    planned, curves = learned()
    run = record(tracker_at(database), planned, curves)
    moved = tmp_path / "moved" / "mlflow.db"
    moved.parent.mkdir()
    for name in ("mlflow.db", "artifacts"):
        (database.parent / name).rename(moved.parent / name)
    periods = options(moved).reader().periods(StoredRun(run.run_id, artifacts=run.artifacts))
    np.testing.assert_array_equal(periods["steps"], curves.steps)
