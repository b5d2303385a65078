"""Delivery: every record reaches the store exactly once, wherever delivery is interrupted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest

from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.delivery import Delivery, deliver_all
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.spool import Spool, point_name
from rl_design_space.tracking.tracker import SweepEnding
from tests.tracking.stores import copy_database, learned, record, runs, tracker_at, undelivered_tracker_at


@pytest.fixture
def tracker(database: Path) -> MlflowTracker:
    return undelivered_tracker_at(database)


@pytest.fixture
def spool(tracker: MlflowTracker) -> Spool:
    return tracker._spool


def content_of(client, run) -> tuple:
    """Return everything that a run holds except its id and times."""
    names = sorted(run.data.metrics)
    history = {name: [(m.step, m.value) for m in client.get_metric_history(run.info.run_id, name)] for name in names}
    folder = Path(run.info.artifact_uri.removeprefix("file://"))
    files = {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}
    tags = {name: value for name, value in run.data.tags.items() if name != "rl_design_space.spool"}
    return run.info.status, run.data.params, history, tags, {name: files[name] for name in sorted(files)}


class PowerCutError(BaseException):
    """Ends delivery as a killed process would."""


#: Calls that write a point, in order; `log_batch` twice, because there are many values.
CALLS = ("create_run", "log_batch", "log_batch", "log_artifacts", "set_terminated")


def failing_at(client, call: str, number: int, when: str, error: BaseException) -> Iterator[None]:
    """Make a call of the client fail once, before or after it has taken effect."""
    original, count = getattr(type(client), call), 0

    def failing(self, *args: object, **kwargs: object) -> object:
        nonlocal count
        count += 1
        if count == number and when == "before":
            raise error
        result = original(self, *args, **kwargs)
        if count == number and when == "after":
            raise error
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(client), call, failing)
        yield


@pytest.fixture(scope="module")
def expected(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """Content of a run that was delivered without interruption."""
    from mlflow import MlflowClient

    database = tmp_path_factory.mktemp("expected") / "mlflow.db"
    copy_database(empty_database, database)
    record(tracker_at(database), *LONG)
    client = MlflowClient(f"sqlite:///{database}")
    (run,) = runs(client)
    return content_of(client, run)


LONG = learned("task.trials=400")


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("stage", range(len(CALLS)))
def test_an_interrupted_delivery_is_continued(stage: int, when: str, tracker, spool, client, expected: tuple):
    call, number = CALLS[stage], CALLS[: stage + 1].count(CALLS[stage])
    tracker.record(*LONG)
    for _ in failing_at(client, call, number, when, PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(spool, 1)
    assert spool.pending() == [point_name(LONG[0].fingerprint)]
    before = runs(client) if client.get_experiment_by_name("design points") else []
    statuses = [run.info.status for run in before]
    assert statuses in ([], ["RUNNING"], ["FINISHED"])
    if statuses == ["FINISHED"]:
        assert content_of(client, before[0]) == expected
    deliver_all(spool, 1)
    assert spool.pending() == []
    (run,) = runs(client)
    assert content_of(client, run) == expected


@pytest.mark.parametrize("stage", range(len(CALLS)))
def test_a_transient_error_is_retried(stage: int, tracker, spool, client, expected: tuple):
    call, number = CALLS[stage], CALLS[: stage + 1].count(CALLS[stage])
    tracker.record(*LONG)
    problems: list[str | None] = []
    for _ in failing_at(client, call, number, "after", ConnectionError("the connection was reset")):
        Delivery(spool, problems.append, Event(), first_pause=0.01).run_until_empty(60)
    assert problems == [None, "the connection was reset", None]
    (run,) = runs(client)
    assert content_of(client, run) == expected


def test_a_refused_record_is_quarantined_and_others_are_delivered(tracker, spool, client, monkeypatch):
    from mlflow.exceptions import MlflowException
    from mlflow.protos.databricks_pb2 import INVALID_PARAMETER_VALUE

    (bad, curves), (good, _) = learned(), learned("seed=1")
    original = type(client).log_batch

    def refusing(self, run_id: str, **what: object) -> None:
        if self.get_run(run_id).data.tags["fingerprint"] == bad.fingerprint:
            raise MlflowException("not like this", INVALID_PARAMETER_VALUE)
        original(self, run_id, **what)

    monkeypatch.setattr(type(client), "log_batch", refusing)
    for planned in (bad, good):
        tracker.record(planned, curves)
    Delivery(spool, lambda problem: None, Event(), first_pause=0.01).run_until_empty(60)
    assert spool.pending() == []
    assert spool.quarantine_reason(point_name(bad.fingerprint)) == "the store refused it: not like this"
    assert {run.data.tags["fingerprint"]: run.info.status for run in runs(client)} == {
        bad.fingerprint: "KILLED",
        good.fingerprint: "FINISHED",
    }


def test_a_corrupted_record_is_quarantined_and_others_are_delivered(tracker, spool, client):
    (bad, curves), (good, _) = learned(), learned("seed=1")
    for planned in (bad, good):
        tracker.record(planned, curves)
    (spool.folder / point_name(bad.fingerprint)).write_bytes(b"PK nonsense")
    deliver_all(spool, 1)
    assert spool.pending() == []
    assert spool.quarantine_reason(point_name(bad.fingerprint)) == "record is corrupted (checksum mismatch)"
    assert [run.data.tags["fingerprint"] for run in runs(client)] == [good.fingerprint]


def test_a_point_that_another_spool_has_delivered_is_not_stored_twice(tracker, spool, database: Path, client):
    planned, curves = learned()
    tracker.record(replace(planned, studies=("a",)), curves)
    elsewhere = tracker_at(database, spool=str(database.parent / "elsewhere"))
    record(elsewhere, replace(planned, studies=("b",)), curves)
    deliver_all(spool, 1)
    (run,) = runs(client)
    assert {"study.a", "study.b"} <= set(run.data.tags)


def test_a_run_that_another_spool_is_writing_is_not_changed(tracker, spool, database: Path, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    elsewhere = undelivered_tracker_at(database, spool=str(database.parent / "elsewhere"))
    elsewhere.record(planned, curves)
    for _ in failing_at(client, "log_batch", 1, "before", PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(elsewhere._spool, 1)
    deliver_all(spool, 1)
    assert sorted(run.info.status for run in runs(client)) == ["FINISHED", "RUNNING"]


def test_a_run_of_a_dead_process_is_closed(tracker, spool, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    for _ in failing_at(client, "log_batch", 1, "before", PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(spool, 1)
    # The spool was emptied by hand.
    spool.remove(point_name(planned.fingerprint))
    deliver_all(spool, 1)
    (run,) = runs(client)
    assert run.info.status == "KILLED"
    assert run.info.end_time
    assert run.data.tags["rl_design_space.incomplete"] == "the process that wrote it has ended"


def summary_of(tracker: MlflowTracker):
    return tracker.open_sweep(Plan((learned()[0],), studies=("mine",)), "the command")


def test_the_summary_run_of_a_live_sweep_stays_open(tracker, spool, client):
    summary = summary_of(tracker)
    deliver_all(spool, 1)
    # Another process starts.
    deliver_all(Spool(spool.folder), 1)
    assert [run.info.status for run in runs(client, "sweeps")] == ["RUNNING"]
    tracker._locks.release(summary._key)
    deliver_all(Spool(spool.folder), 1)
    assert [run.info.status for run in runs(client, "sweeps")] == ["KILLED"]


@pytest.mark.parametrize("delivered", [True, False])
def test_the_summary_run_of_an_ended_sweep_gets_its_status(tracker, spool, client, delivered: bool):
    summary = summary_of(tracker)
    if delivered:
        deliver_all(spool, 1)
    summary.close(SweepEnding("FAILED", "1 failed", {"failed": 1}, {}, {}))
    # Its lock is released, but its record says how it ended.
    deliver_all(spool, 1)
    (run,) = runs(client, "sweeps")
    assert run.info.status == "FAILED"
    assert run.data.metrics == {"points/failed": 1}
    assert run.info.start_time == summary._content["started"]


def test_a_point_whose_run_was_deleted_is_missing(database: Path, client):
    planned, curves = learned()
    tracker = tracker_at(database)
    client.delete_run(record(tracker, planned, curves).run_id)
    assert tracker.finished([planned.fingerprint]) == {}
    again = record(tracker, planned, curves)
    assert [run.info.run_id for run in runs(client)] == [again.run_id]
