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
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.courier import Courier
from rl_design_space.tracking.spool import STUDIES, Record, Spool
from tests.command_runner import wait_until

LOWEST, _PATIENCE = 19, 30


class Watched:
    """Stands for a writer, and notes at which priority it is let work."""

    def __init__(self, ended: Event) -> None:
        self.noted: Queue[int | str] = Queue()
        self._ended = ended

    def run_until(self, stopped: Callable[[], bool]) -> None:
        self.noted.put(os.getpriority(os.PRIO_PROCESS, 0))
        wait_until(lambda: stopped() or self._ended.is_set(), seconds=_PATIENCE)

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


class Started:
    """Stands for tracker processes: says what is given, listens until its input ends, and delivers nothing."""

    def __init__(self, heard: Path, says: str) -> None:
        self.paces: list[str] = []
        self._code = (
            f"import sys; print({says!r}, flush=True); open({str(heard)!r}, 'ab').write(sys.stdin.buffer.read())"
        )
        self._start = subprocess.Popen

    def __call__(self, command: list[str], **streams: object) -> subprocess.Popen[bytes]:
        self.paces.append(command[-1])
        return self._start([sys.executable, "-c", self._code], **streams)


@pytest.mark.parametrize(
    ("says", "paces", "told"),
    [
        ('{"trouble": null}', ["calm"], "hurry\ncalm\nhurry\n"),
        ('{"trouble": "the disk is full"}', ["calm"], "hurry\ncalm\n"),
        ("", ["calm", "hurry"], "calm\nhurry\n"),
    ],
    ids=["an open store", "trouble", "a store that is not opened, so another process is started"],
)
def test_a_tracker_process_is_told_whether_it_is_waited_for(
    says: str, paces: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    started = Started(tmp_path / "heard", says)
    monkeypatch.setattr(subprocess, "Popen", started)
    for name, seconds in (("_QUIET", 2), ("_LEAVING", 1), ("_OPENING", 0.5)):
        monkeypatch.setattr(courier, name, seconds)
    spool = Spool.of(tmp_path, StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps"))
    spool.write(Record(STUDIES, "0", {}))
    one = Courier(spool)
    one.wake()
    wait_until(lambda: started.paces, seconds=_PATIENCE)
    assert one.settle(patience=2).awaiting == 1
    sleep(0.2)
    one.leave()
    assert started.paces == paces
    assert (tmp_path / "heard").read_text().endswith(told)
