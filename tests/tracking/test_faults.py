"""Real faults, through the real command: no point is lost or stored twice, no run stays RUNNING."""

from __future__ import annotations

import os
import re
import signal
import sqlite3
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from threading import Thread
from time import sleep

import pytest

from tests.command_runner import PATIENCE, commands_in, finished, output_of, started, wait_until
from tests.run.kills import Store
from tests.tracking.faults import Sabotage
from tests.tracking.stores import copy_database

SWEEP = ("-m", "task.periods=3", "task.trials=10", "world.size=4,5,6", "outputs=out")
POINTS = 3


@pytest.fixture
def folder(tmp_path: Path, empty_database: Path) -> Path:
    """A folder with an empty database."""
    (tmp_path / "out").mkdir()
    copy_database(empty_database, tmp_path / "out" / "mlflow.db")
    return tmp_path


def check(folder: Path, sweeps: set[str] = frozenset({"FINISHED"})) -> None:
    """Check that every point is stored once and complete, nothing is RUNNING, and no record is pending."""
    store = Store(folder / "out" / "mlflow.db")
    assert sorted(store.finished().values()) == [1] * POINTS
    assert store.incomplete() == 0
    assert set(store.statuses()) <= {"FINISHED", "KILLED"}
    assert set(store.sweeps()) <= sweeps
    assert not list((folder / "out" / "spool").glob("*/*.record"))


#: Stages of writing a batch: of opening the sweep, of its points, and of closing it.
STAGES = (
    "before runs 1",
    "before metrics 1",
    "before commit 1",
    "after commit 1",
)


def test_a_tracker_process_that_is_killed_at_every_stage_is_restarted(folder: Path):
    sabotage = Sabotage(folder, "tracker")
    # Stages are counted from the start of a tracker process, so each process is killed at one of them.
    status, output = sabotage.run(*SWEEP, faults=(STAGES[0], "after latest_metrics 1", STAGES[3]))
    assert status == 0, output
    check(folder)
    status, output = sabotage.run(*SWEEP, "seed=1", faults=("after params 1", "before commit 1"))
    assert status == 0, output
    assert sorted(Store(folder / "out" / "mlflow.db").finished().values()) == [1] * 2 * POINTS
    assert Store(folder / "out" / "mlflow.db").sweeps() == ["FINISHED"] * 2


def test_a_sweep_that_is_killed_at_every_stage_is_resumed(folder: Path):
    sabotage = Sabotage(folder, "sweep")
    for stage in STAGES:
        status, output = sabotage.run(*SWEEP, faults=(stage,))
        assert status == -signal.SIGKILL, output
    status, output = sabotage.run(*SWEEP)
    assert status == 0, output
    check(folder, {"FINISHED", "KILLED"})


def test_a_locked_database_is_retried(folder: Path):
    store = Store(folder / "out" / "mlflow.db")
    with started(folder, *SWEEP) as process:
        wait_until(store.statuses, process)
        with closing(sqlite3.connect(store.database, isolation_level=None, timeout=30)) as other:
            other.execute("BEGIN EXCLUSIVE")
            sleep(6)
            other.execute("ROLLBACK")
        done = finished(process)
    assert done.returncode == 0, done.stdout
    check(folder)


def test_a_killed_sweep_learns_again_only_the_point_whose_record_is_corrupted(folder: Path):
    sabotage = Sabotage(folder, "sweep")
    # All is learned by then: starting the tracker process takes seconds, learning does not.
    status, output = sabotage.run(*SWEEP, faults=("before params 1",))
    assert status == -signal.SIGKILL, output
    damaged = next((folder / "out" / "spool").glob("*/1-point-*"))
    damaged.write_bytes(damaged.read_bytes()[:-1])
    status, output = sabotage.run(*SWEEP)
    assert status == 0, output
    assert "1 learned now, 2 before" in output
    (quarantined,) = (folder / "out" / "spool").glob("*/aside/*.record")
    assert quarantined.name.endswith(damaged.name)
    check(folder, {"FINISHED", "KILLED"})


# Full disks.


@pytest.fixture
def small_disk(tmp_path: Path, empty_database: Path) -> Iterator[Path]:
    """A folder whose outputs are on a small file system of their own."""
    (tmp_path / "out").mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=24m", "none", str(tmp_path / "out")]
    if os.geteuid() != 0 or subprocess.run(mount, check=False, capture_output=True, timeout=PATIENCE).returncode:
        pytest.skip("needs the right to mount a small file system")
    try:
        copy_database(empty_database, tmp_path / "out" / "mlflow.db")
        yield tmp_path
    finally:
        output_of("umount", "--lazy", tmp_path / "out")


def fill(folder: Path, left: int = 40_960) -> Path:
    """Fill the disk except for some bytes; return the file that fills it."""
    filler = folder / "out" / "filler"
    with filler.open("wb", buffering=0) as file:
        try:
            while file.write(b"\0" * 4096):
                pass
        except OSError:
            pass
        file.truncate(max(file.tell() - left, 0))
    return filler


def test_a_full_disk_is_retried(small_disk: Path):
    filler = fill(small_disk)
    thread = Thread(target=lambda: (sleep(6), filler.unlink()))
    thread.start()
    done = commands_in(small_disk)("rl-design-space", *SWEEP[:-1])
    thread.join(PATIENCE)
    check(small_disk)
    assert "3 learned now" in done.stdout


def test_a_disk_that_stays_full_ends_the_sweep_and_loses_nothing(small_disk: Path):
    filler = fill(small_disk, left=0)
    command = commands_in(small_disk)
    done = command("rl-design-space", *SWEEP[:-1], "tracking.patience=2", status=2)
    assert re.search(r"error: .*/out/.*: No space left on device; ", done.stderr)
    filler.unlink()
    command("rl-design-space", *SWEEP[:-1])
    check(small_disk, {"FINISHED", "KILLED"})


def test_results_stay_pending_while_the_disk_of_the_store_is_full(
    small_disk: Path, tmp_path_factory: pytest.TempPathFactory
):
    filler = fill(small_disk, left=0)
    command, elsewhere = commands_in(small_disk), f"tracking.spool={tmp_path_factory.mktemp('spool')}"
    done = command("rl-design-space", *SWEEP[:-1], "tracking.patience=2", elsewhere, status=1)
    assert "3 learned now" in done.stdout
    assert re.search(r"5 results .* safe on disk, not yet in .*(full|I/O)", done.stdout)
    assert "rl-design-space sync" in done.stdout
    filler.unlink()
    done = command("rl-design-space", "sync", elsewhere)
    assert "5 records delivered" in done.stdout
    check(small_disk)
