"""Readers of recorded runs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND
from rl_design_space.tracking import NoTracking
from tests.tracking.stores import learned, options, record, tracker_at


def test_every_trial_of_every_period_is_read(database: Path):
    planned, curves = learned("seed=3")
    record(tracker_at(database), planned, curves)
    reader = options(database).reader()
    arrays = reader.periods(reader.finished([planned.fingerprint])[planned.fingerprint])
    assert set(arrays) == {"steps", "success", "optimum", "rows", *CURVES, *CURVES_ON_DEMAND}
    np.testing.assert_array_equal(arrays["steps"], curves.steps)
    np.testing.assert_array_equal(arrays["success"], curves.success)
    np.testing.assert_array_equal(arrays["optimum"], curves.optimum)
    for name, curve in curves.curves.items():
        np.testing.assert_array_equal(arrays[name], curve)


def test_only_complete_runs_are_read(database: Path):
    from mlflow import MlflowClient

    (one, curves), (other, _) = learned(), learned("seed=1")
    tracker = tracker_at(database)
    stored = record(tracker, one, curves)
    reader = options(database).reader()
    assert reader.finished([one.fingerprint, other.fingerprint]) == tracker.finished([one.fingerprint])
    MlflowClient(f"sqlite:///{database}").update_run(stored.run_id, status="RUNNING")
    assert reader.finished([one.fingerprint, other.fingerprint]) == {}


def test_reading_leaves_no_temporary_files(database: Path, monkeypatch: pytest.MonkeyPatch):
    planned, curves = learned()
    stored = record(tracker_at(database), planned, curves)
    reader = options(database).reader()
    temporary = database.parent / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    reader.periods(stored)
    assert list(temporary.iterdir()) == []


def test_a_store_without_runs_is_reported_and_not_created(tmp_path: Path):
    database = tmp_path / "none" / "mlflow.db"
    with pytest.raises(ConfigError, match=r"tracking\.uri=sqlite:.*: no run has been recorded there yet"):
        options(database).reader()
    assert list(tmp_path.iterdir()) == []


def test_an_experiment_that_does_not_exist_is_reported(database: Path):
    with pytest.raises(ConfigError, match=r"tracking\.experiment=design points: there is no such experiment"):
        options(database).reader()


def test_a_reader_without_tracking_is_refused():
    with pytest.raises(ConfigError, match="tracking=none: nothing was recorded"):
        NoTracking().reader()
