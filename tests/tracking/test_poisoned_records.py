"""Records whose checksum is right and whose content is not: quarantined by name, and the others are delivered."""

from __future__ import annotations

import copy
import hashlib
import json
import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.content import content_of
from rl_design_space.tracking.delivery import deliver_all
from rl_design_space.tracking.record import point_record
from rl_design_space.tracking.record_schema import checked
from rl_design_space.tracking.spool import CorruptedRecordError, Spool, point_name
from tests.tracking.stores import learned, runs, undelivered_tracker_at

POINT = point_record(*learned(), {"mlflow.user": "me"})
RESULT = b"".join(POINT.files.values())
#: What the first line of a record's file holds.
HEADER = {
    "kind": POINT.kind,
    "key": POINT.key,
    "content": POINT.content,
    "files": {name: len(content) for name, content in POINT.files.items()},
}
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=5), inner, max_size=2),
    max_leaves=4,
)


@st.composite
def poisoned_headers(draw: st.DrawFn) -> dict[str, Any]:
    """Return what the first line of a record holds, with one value at any depth removed or replaced."""
    header = copy.deepcopy(HEADER)
    place, depth = header, draw(st.integers(0, 2))
    for _ in range(depth):
        inner = sorted(name for name, value in place.items() if isinstance(value, dict) and value)
        if inner:
            place = place[draw(st.sampled_from(inner))]
    name = draw(st.sampled_from(sorted(place)))
    if draw(st.booleans()):
        del place[name]
    else:
        place[name] = draw(JSON)
    return header


def write(spool: Spool, name: str, packed: bytes) -> None:
    """Write a record with the right checksum, whatever it holds."""
    (spool.folder / name).write_bytes(hashlib.sha256(packed).digest() + packed)


def poisoned(header: dict[str, Any]) -> bytes:
    return json.dumps(header).encode() + b"\n" + RESULT


@pytest.fixture(scope="module")
def scratch(tmp_path_factory: pytest.TempPathFactory) -> Spool:
    return Spool.of(tmp_path_factory.mktemp("spool"), StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps"))


@settings(max_examples=100, deadline=None)
@given(header=poisoned_headers())
def test_a_record_is_read_or_corrupted(scratch: Spool, header: dict[str, Any]):
    write(scratch, POINT.name, poisoned(header))
    with suppress(CorruptedRecordError):
        content_of(checked(scratch.read(POINT.name)), "a")


@settings(max_examples=100, deadline=None)
@given(at=st.integers(0, len(RESULT) - 1), flip=st.integers(1, 255), cut=st.booleans())
def test_a_result_is_read_or_corrupted(at: int, flip: int, cut: bool):
    result = bytearray(RESULT)
    if cut:
        del result[at:]
    else:
        result[at] ^= flip
    with suppress(CorruptedRecordError):
        content_of(replace(POINT, files={name: bytes(result) for name in POINT.files}), "a")


POISONS = {
    "a kind that does not exist": (lambda header: header.update(kind="other"), "its kind, key or content"),
    "a size that is no number": (lambda header: header.update(files={"result": "many"}), "cannot be read"),
    "a file elsewhere": (lambda header: header.update(files={"../result": 3}), "a file '../result' of 3 bytes"),
    "no tags": (lambda header: header["content"].pop("tags"), "tags: Field required"),
    "a number that is text": (lambda header: header["content"].update(started="now"), "started: Input should be"),
    "a metric that is text": (lambda header: header["content"]["scalars"].update(x="y"), r"scalars\.x: Input should"),
    "no result": (lambda header: header.update(files={}), "its result cannot be read"),
}


def test_poisoned_records_are_quarantined_and_others_are_delivered(database: Path, client):
    tracker = undelivered_tracker_at(database)
    good, curves = learned()
    tracker.record(good, curves)
    spool, names = tracker._spool, {}
    for number, (poison, _) in enumerate(POISONS.values()):
        header = copy.deepcopy(HEADER) | {"key": f"{number:064}"}
        poison(header)
        names[point_name(header["key"])] = number
        write(spool, point_name(header["key"]), poisoned(header))
    assert deliver_all(spool, 1) == ""
    assert spool.pending() == []
    assert [run.data.tags["fingerprint"] for run in runs(client)] == [good.fingerprint]
    for (_, reason), name in zip(POISONS.values(), names, strict=True):
        assert re.search(rf"^record is corrupted \(.*{reason}", spool.quarantine_reason(name) or "")


def test_a_poisoned_record_does_not_count(database: Path):
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    tracker.record(planned, curves)
    header = copy.deepcopy(HEADER)
    del header["content"]["scalars"]
    write(tracker._spool, point_name(planned.fingerprint), poisoned(header))
    assert tracker.finished([planned.fingerprint]) == {}
    assert tracker._spool.pending() == []
