"""The spool: a record is there completely or not at all, and corruption is detected."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path

import pytest
from filelock import Timeout
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.spool import (
    CLOSE,
    KINDS,
    OPEN,
    POINT,
    STUDIES,
    TIDY,
    CorruptedRecordError,
    Record,
    Spool,
    point_name,
)

ADDRESS = StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps")
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)
RECORDS = st.builds(
    Record,
    st.sampled_from(KINDS),
    st.text("0123456789abcdef", min_size=1, max_size=64),
    st.dictionaries(st.text(), PLAIN, max_size=4),
    st.dictionaries(st.sampled_from(["periods.npz", "config.yaml", "ä.csv"]), st.binary(max_size=300)),
)


@pytest.fixture
def spool(tmp_path: Path) -> Spool:
    return Spool.of(tmp_path / "spool", ADDRESS)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(record=RECORDS)
def test_a_record_is_read_as_it_was_written(spool: Spool, record: Record):
    spool.write(record)
    assert spool.has(record.name)
    assert spool.read(record.name) == record
    spool.remove(record.name)
    assert spool.pending() == []


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100, deadline=None)
@given(record=RECORDS, at=st.floats(0, 1, exclude_max=True), flip=st.integers(1, 255), cut=st.booleans())
def test_corruption_is_detected(spool: Spool, record: Record, at: float, flip: int, cut: bool):
    spool.write(record)
    path = spool.folder / record.name
    content = bytearray(path.read_bytes())
    place = int(at * len(content))
    if cut:
        del content[place:]
    else:
        content[place] ^= flip
    path.write_bytes(content)
    with pytest.raises(CorruptedRecordError, match=r"record is corrupted \(checksum mismatch\)"):
        spool.read(record.name)
    spool.remove(record.name)


def test_a_record_under_the_name_of_another_is_corrupted(spool: Spool):
    spool.write(Record(POINT, "a", {}))
    (spool.folder / point_name("a")).rename(spool.folder / point_name("b"))
    with pytest.raises(CorruptedRecordError, match=r"corrupted \(its file holds 1-point-a"):
        spool.read(point_name("b"))


def test_pending_records_are_in_the_order_of_delivery(spool: Spool):
    for kind in (TIDY, CLOSE, STUDIES, POINT, OPEN):
        spool.write(Record(kind, "0", {}))
    assert [spool.read(name).kind for name in spool.pending()] == [OPEN, POINT, STUDIES, CLOSE, TIDY]


@pytest.mark.parametrize("broken", ["fsync", "replace"])
def test_a_record_that_cannot_be_written_leaves_no_file(spool: Spool, broken: str, monkeypatch: pytest.MonkeyPatch):
    before = sorted(spool.folder.iterdir())

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(*((os, "fsync") if broken == "fsync" else (Path, "replace")), full)
    with pytest.raises(OSError, match="No space"):
        spool.write(Record(POINT, "a", {}))
    assert sorted(spool.folder.iterdir()) == before


def test_a_temporary_file_is_not_a_record(spool: Spool):
    new = spool.folder / f".{point_name('a')}.123.new"
    new.write_bytes(b"half")
    assert spool.pending() == []
    spool.remove_abandoned()
    assert new.exists()
    an_hour_and_a_bit = time.time() - 3700
    os.utime(new, (an_hour_and_a_bit, an_hour_and_a_bit))
    spool.remove_abandoned()
    assert not new.exists()


def test_a_quarantined_record_is_kept_with_the_reason(spool: Spool):
    name = point_name("a")
    for content in ({"n": 1}, {"n": 2}):
        spool.write(Record(POINT, "a", content))
        spool.quarantine(name, f"refused: {content}")
    assert spool.pending() == []
    first, second = spool.quarantined()
    assert first.read_bytes() != second.read_bytes()
    assert spool.quarantine_reason(name) == "refused: {'n': 2}"
    assert spool.quarantine_reason(name, since=time.time_ns()) is None
    assert spool.quarantine_reason(point_name("b")) is None
    spool.quarantine(name, "another process has done so")


def test_a_spool_belongs_to_one_store(tmp_path: Path):
    other = StoreAddress(ADDRESS.uri, "others", "sweeps")
    one, same, another = (Spool.of(tmp_path, address) for address in (ADDRESS, ADDRESS, other))
    assert one.folder == same.folder != another.folder
    assert one.identity == same.identity != another.identity
    assert {spool.address for spool in Spool.all_under(tmp_path)} == {ADDRESS, other}
    assert Spool.all_under(tmp_path / "nowhere") == []


def test_one_process_delivers_at_a_time(spool: Spool):
    with spool.lock, pytest.raises(Timeout):
        Spool(spool.folder).lock.acquire(timeout=0)
