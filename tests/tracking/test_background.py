"""Background delivery: when a record counts as delivered, and at which priority the tracker process works."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from time import sleep

import pytest

from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.background import BackgroundDelivery, Timeouts
from rl_design_space.tracking.spool import POINT, STUDIES, Record, Spool
from rl_design_space.tracking.tracker_process import BACKGROUND, FOREGROUND
from tests.command_runner import PATIENCE, wait_until

ADDRESS = StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps")
RECORD = Record(POINT, "a", {})


class BusySpool(Spool):
    """A spool in which something happens each time right after its folder has been read."""

    happens: Callable[[], None] = staticmethod(lambda: None)

    def pending(self) -> list[str]:
        names = super().pending()
        self.happens()
        return names


class WithoutProcess(BackgroundDelivery):
    """Background delivery that starts no thread and no process."""

    def start(self) -> None:
        pass


@pytest.mark.parametrize("earlier", [False, True], ids=["a new record", "in place of an earlier one"])
def test_a_record_written_while_the_folder_is_read_stays_pending(earlier: bool, tmp_path: Path):
    spool = BusySpool.of(tmp_path, ADDRESS)
    delivery = WithoutProcess(spool)
    done: list[str] = []
    if earlier:
        delivery.watch(RECORD.name, lambda: done.append("earlier"))

    def write() -> None:
        spool.write(RECORD)
        delivery.watch(RECORD.name, lambda: done.append("delivered"))

    spool.happens = write
    delivery._note_deliveries()
    assert (delivery.pending, done) == (1, [])
    spool.happens = lambda: None
    spool.remove(RECORD.name)
    delivery._note_deliveries()
    assert (delivery.pending, done) == (0, ["delivered"])


def test_a_quarantined_point_is_reported_as_lost_once(tmp_path: Path):
    spool = Spool.of(tmp_path, ADDRESS)
    delivery = WithoutProcess(spool)
    for record in (RECORD, Record(STUDIES, "0", {})):
        spool.write(record)
        delivery.watch(record.name, lambda: None)
        spool.quarantine(record.name, "record was refused")
    delivery._note_deliveries()
    statuses = [delivery.wait(patience=1) for _ in range(2)]
    assert [status.lost for status in statuses] == [{"a": "record was refused"}, {}]
    assert [status.pending for status in statuses] == [0, 0]


class FakeProcesses:
    """Stands for tracker processes: they send a message, record their input until it ends, and deliver nothing."""

    def __init__(self, received: Path, message: str) -> None:
        self.priorities: list[str] = []
        self._code = (
            f"import sys; print({message!r}, flush=True); open({str(received)!r}, 'ab').write(sys.stdin.buffer.read())"
        )
        self._start = subprocess.Popen

    def __call__(self, command: list[str], **streams: object) -> subprocess.Popen[bytes]:
        self.priorities.append(command[-1])
        return self._start([sys.executable, "-c", self._code], **streams)


@pytest.mark.parametrize(
    ("message", "priorities", "received"),
    [
        ('{"problem": null}', [BACKGROUND], [FOREGROUND, BACKGROUND, FOREGROUND]),
        ('{"problem": "the disk is full"}', [BACKGROUND], [FOREGROUND, BACKGROUND]),
        ("", [BACKGROUND, FOREGROUND], [BACKGROUND, FOREGROUND]),
    ],
    ids=["the store is open", "a problem", "the store is not opened, so the process is replaced"],
)
def test_a_tracker_process_that_is_waited_for_is_in_the_foreground(
    message: str, priorities: list[str], received: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    processes = FakeProcesses(tmp_path / "received", message)
    monkeypatch.setattr(subprocess, "Popen", processes)
    spool = Spool.of(tmp_path, ADDRESS)
    spool.write(Record(STUDIES, "0", {}))
    delivery = BackgroundDelivery(spool, Timeouts(silence=2, leaving=1, opening=0.5))
    delivery.start()
    wait_until(lambda: processes.priorities)
    assert delivery.wait(patience=2).pending == 1
    sleep(0.2)
    delivery.leave()
    assert processes.priorities == priorities
    assert (tmp_path / "received").read_text().split()[-len(received) :] == received


def test_a_store_that_cannot_be_used_is_reported_and_no_other_process_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    from rl_design_space.errors import ConfigError

    processes = FakeProcesses(tmp_path / "received", '{"unusable": "access denied"}')
    monkeypatch.setattr(subprocess, "Popen", processes)
    spool = Spool.of(tmp_path, ADDRESS)
    spool.write(Record(STUDIES, "0", {}))
    delivery = BackgroundDelivery(spool, Timeouts(silence=PATIENCE))
    with pytest.raises(ConfigError, match="access denied"):
        delivery.wait(patience=1)
    delivery.leave()
    assert len(processes.priorities) == 1
