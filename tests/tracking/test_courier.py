"""The courier knows what is delivered, and takes nothing else for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.courier import Courier
from rl_design_space.tracking.spool import POINT, Record, Spool

RECORD = Record(POINT, "a", {})


class Busy(Spool):
    """A spool in which something happens each time right after its folder has been read."""

    happens: Callable[[], None] = staticmethod(lambda: None)

    def waiting(self) -> list[str]:
        names = super().waiting()
        self.happens()
        return names


@pytest.fixture
def spool(tmp_path: Path) -> Busy:
    return Busy.of(tmp_path, StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps"))


@pytest.fixture
def courier(spool: Busy, monkeypatch: pytest.MonkeyPatch) -> Courier:
    """One that starts no process."""
    monkeypatch.setattr(Courier, "wake", lambda self: None)
    return Courier(spool)


@pytest.mark.parametrize("earlier", [False, True], ids=["a new record", "in place of an earlier one"])
def test_a_record_that_is_written_while_the_folder_is_read_still_waits(earlier: bool, courier: Courier, spool: Busy):
    done: list[str] = []
    if earlier:
        courier.watch(RECORD.name, lambda: done.append("earlier"))

    def write() -> None:
        spool.write(RECORD)
        courier.watch(RECORD.name, lambda: done.append("delivered"))

    spool.happens = write
    courier._look()
    assert (courier.left, done) == (1, [])
    spool.happens = lambda: None
    spool.remove(RECORD.name)
    courier._look()
    assert (courier.left, done) == (0, ["delivered"])
