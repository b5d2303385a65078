"""Records of points: everything that a run holds follows from its record."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.learning import LearningCurves
from rl_design_space.tracking.address import StoreAddress
from rl_design_space.tracking.content import content_of, metrics
from rl_design_space.tracking.record import point_record, result_of
from rl_design_space.tracking.spool import CorruptedRecordError, Record, Spool
from tests.learning.strategies import results
from tests.tracking.stores import learned

PLANNED, CURVES = learned()
ON_DEMAND = ("steps/q10", "steps/q90", "steps/over_optimum", "epsilon")


@pytest.fixture(scope="module")
def spool(tmp_path_factory: pytest.TempPathFactory) -> Spool:
    return Spool.of(tmp_path_factory.mktemp("spool"), StoreAddress("sqlite:////srv/mlflow.db", "points", "sweeps"))


def through(spool: Spool, record: Record) -> Record:
    """Write a record, and read it."""
    spool.write(record)
    return spool.read(record.name)


@settings(deadline=None)
@given(result=results(PLANNED.point))
def test_a_result_is_read_bit_by_bit(spool: Spool, result: LearningCurves):
    back = result_of(through(spool, point_record(PLANNED, result, {})))
    assert back.seconds == result.seconds
    for name in ("steps", "success", "optimum", "rows", "epsilon"):
        one, other = getattr(back, name), getattr(result, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


@settings(deadline=None)
@given(result=results(PLANNED.point), every=st.integers(1, 4))
def test_a_run_gets_the_metrics_of_the_result(spool: Spool, result: LearningCurves, every: int):
    record = through(spool, point_record(PLANNED, result, {}, curves=ON_DEMAND, every=every))
    scalars = result.scalars()
    assert content_of(record, "a").metrics == metrics(result, scalars, ON_DEMAND, every)


def test_a_record_of_version_0_1_0_is_read(spool: Spool):
    """It held the arrays one after the other, steps as narrow as they fit."""
    buffer = BytesIO()
    for name in ("steps", "success", "optimum", "rows", "epsilon"):
        array = getattr(CURVES, name)
        np.save(buffer, array.astype(np.uint16) if name == "steps" else array)
    new = point_record(PLANNED, CURVES, {})
    old = replace(new, files={"result": buffer.getvalue()})
    assert content_of(through(spool, old), "a") == content_of(new, "a")


def test_a_file_in_an_unknown_format_is_corrupted(tmp_path: Path):
    other = Spool(tmp_path)
    record = point_record(PLANNED, CURVES, {})
    content = b"PK\x03\x04 an archive"
    (tmp_path / record.name).write_bytes(hashlib.sha256(content).digest() + content)
    with pytest.raises(CorruptedRecordError, match="cannot be read"):
        other.read(record.name)
