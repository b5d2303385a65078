"""The tracker process by itself: its priorities, and delivery after the process that started it has died."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from queue import Queue
from threading import Event, Thread

import pytest

from rl_design_space.tracking import process
from rl_design_space.tracking.record import point_record
from rl_design_space.tracking.spool import Spool
from rl_design_space.tracking.tracker_process import FOREGROUND
from tests.command_runner import PATIENCE, environment, wait_until
from tests.tracking.stores import copy_database, learned, options

POINTS = 3
LOWEST = 19


class NotingDelivery:
    """Stands for a delivery, and notes the niceness of the thread that it runs in."""

    def __init__(self, ended: Event) -> None:
        self.noted: Queue[int | str] = Queue()
        self._ended = ended

    def run_while(self, active: Callable[[], bool]) -> None:
        self.noted.put(os.getpriority(os.PRIO_PROCESS, 0))
        wait_until(lambda: not active() or self._ended.is_set(), pause=0.001)

    def deliver_summaries(self) -> None:
        self.noted.put("summaries")


@pytest.mark.skipif(sys.platform != "linux", reason="threads have priorities of their own on Linux only")
def test_the_priority_is_lowest_in_the_background_and_normal_in_the_foreground():
    normal = os.getpriority(os.PRIO_PROCESS, 0)
    ended, foreground = Event(), Event()
    delivery = NotingDelivery(ended)
    Thread(target=process._deliver, args=(delivery, ended, foreground), daemon=True).start()
    assert delivery.noted.get(timeout=PATIENCE) == LOWEST
    foreground.set()
    assert delivery.noted.get(timeout=PATIENCE) == normal
    foreground.clear()
    assert delivery.noted.get(timeout=PATIENCE) == LOWEST
    ended.set()
    assert [delivery.noted.get(timeout=PATIENCE) for _ in range(2)] == [normal, "summaries"]
    assert os.getpriority(os.PRIO_PROCESS, 0) == normal


@pytest.fixture
def spool(empty_database: Path, tmp_path: Path) -> Spool:
    """A spool with pending records of a few points, for a SQLite database."""
    copy_database(empty_database, tmp_path / "mlflow.db")
    (tmp_path / "temporary").mkdir()
    chosen = options(tmp_path / "mlflow.db")
    spool = Spool.of(Path(chosen.spool), chosen.address)
    for seed in range(POINTS):
        planned, curves = learned(f"seed={seed}")
        spool.write(point_record(replace(planned, studies=("mine",)), curves, {}))
    return spool


def test_delivery_loses_nothing_when_the_parent_has_died_and_others_read_the_database(spool: Spool, tmp_path: Path):
    command = [sys.executable, "-m", "rl_design_space.tracking.process", str(spool.folder), FOREGROUND]
    child = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=tmp_path, env=environment(tmp_path)
    )
    child.stdout.close()

    def delivered() -> bool:
        finished(tmp_path / "mlflow.db")  # opens and closes the database: the last to close it removes its log
        return not spool.pending()

    wait_until(delivered, pause=0.001)
    child.stdin.close()
    child.wait(PATIENCE)
    assert finished(tmp_path / "mlflow.db") == POINTS


def finished(database: Path) -> int:
    with closing(sqlite3.connect(database, timeout=30)) as reader:
        (count,) = reader.execute("select count(*) from runs where status = 'FINISHED'").fetchone()
    return count
