"""Learning comes first: the tracker process holds back until nobody learns any more."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from threading import Event, Thread
from time import sleep

import pytest

from rl_design_space.tracking import courier, process
from rl_design_space.tracking.courier import Courier
from rl_design_space.tracking.spool import STUDIES, Record, Spool
from rl_design_space.tracking.store import StoreAddress

LOWEST, _PATIENCE = 19, 30


class Watched:
    """Stands for a writer, and notes at which priority it is let work."""

    def __init__(self, ended: Event) -> None:
        self.noted: Queue[int | str] = Queue()
        self._ended = ended

    def run_until(self, stopped: Callable[[], bool]) -> None:
        self.noted.put(os.getpriority(os.PRIO_PROCESS, 0))
        while not (stopped() or self._ended.is_set()):
            sleep(0.001)

    def leave(self) -> None:
        self.noted.put("left")


@pytest.mark.skipif(sys.platform != "linux", reason="the priority of a thread is Linux's")
def test_work_is_done_at_the_lowest_priority_but_in_a_hurry():
    mine = os.getpriority(os.PRIO_PROCESS, 0)
    ended, hurried = Event(), Event()
    watched = Watched(ended)
    Thread(target=process._deliver, args=(watched, ended, hurried), daemon=True).start()
    assert watched.noted.get(timeout=_PATIENCE) == LOWEST
    hurried.set()
    assert watched.noted.get(timeout=_PATIENCE) == mine
    hurried.clear()
    assert watched.noted.get(timeout=_PATIENCE) == LOWEST
    ended.set()
    assert [watched.noted.get(timeout=_PATIENCE) for _ in range(2)] == [mine, "left"]
    assert os.getpriority(os.PRIO_PROCESS, 0) == mine


def test_the_tracker_process_is_told_whether_anybody_waits_for_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    heard, start = tmp_path / "heard", subprocess.Popen
    listener = [sys.executable, "-c", f"import sys; open({str(heard)!r}, 'wb').write(sys.stdin.buffer.read())"]
    monkeypatch.setattr(subprocess, "Popen", lambda command, **streams: start(listener, **streams))
    for name in ("_QUIET", "_LEAVING"):
        monkeypatch.setattr(courier, name, 0.5)
    spool = Spool.of(tmp_path, StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps"))
    spool.write(Record(STUDIES, "0", {}))
    one = Courier(spool)
    assert one.settle(patience=0.5).awaiting == 1
    one.leave()
    assert heard.read_bytes() == process.HURRY + process.CALM
