"""Delivery: every record reaches the store exactly once, wherever delivery is interrupted."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest
from mlflow import MlflowClient
from mlflow.exceptions import MlflowException
from mlflow.protos.databricks_pb2 import INVALID_PARAMETER_VALUE
from sqlalchemy.engine.default import DefaultDialect

from rl_design_space.plan.plan import Plan
from rl_design_space.tracking import database_tables
from rl_design_space.tracking.database_runs import DatabaseRuns
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
    """Return everything that a run holds except its id and times; its note has an address with the id."""
    names = sorted(run.data.metrics)
    history = {name: [(m.step, m.value) for m in client.get_metric_history(run.info.run_id, name)] for name in names}
    folder = Path(run.info.artifact_uri.removeprefix("file://"))
    files = {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}
    tags = {name: value for name, value in run.data.tags.items() if name != "rl_design_space.spool"}
    tags["mlflow.note.content"] = tags["mlflow.note.content"].replace(run.info.run_id, "RUN")
    return run.info.status, run.data.params, history, tags, {name: files[name] for name in sorted(files)}


class PowerCutError(BaseException):
    """Ends delivery as a killed process would."""


#: Calls of MLflow's client that write a point, in order; `log_batch` twice, because there are many values.
CALLS = ("create_run", "log_batch", "log_batch", "log_artifacts", "set_terminated")
#: What writes a point directly into a database, in order.
STATEMENTS = ("INSERT INTO runs", "INSERT INTO params", "INSERT INTO metrics", "INSERT INTO latest_metrics", "commit")
STAGES = [("client", stage) for stage in range(len(CALLS))] + [("directly", stage) for stage in STATEMENTS]


@pytest.fixture
def by_client(monkeypatch: pytest.MonkeyPatch) -> None:
    """Write with MLflow's client, as into a database of an unknown schema."""
    monkeypatch.setattr(database_tables, "REVISIONS", frozenset())


@contextmanager
def failing_at(way: str, stage: int | str, when: str, error: BaseException) -> Iterator[None]:
    """Make writing fail once, before or after a stage has taken effect."""
    with pytest.MonkeyPatch.context() as patch:
        if way == "client":
            patch.setattr(database_tables, "REVISIONS", frozenset())
            call, number = CALLS[stage], CALLS[: stage + 1].count(CALLS[stage])
            _fail_once(patch, MlflowClient, call, when, error, number=number)
        elif stage == "commit":
            begun = _fail_once(patch, DefaultDialect, "do_execute", "never", error, matching=STATEMENTS[0])
            _fail_once(patch, DefaultDialect, "do_commit", when, error, ready=begun)
        else:
            for name in ("do_execute", "do_executemany"):
                _fail_once(patch, DefaultDialect, name, when, error, matching=stage)
        yield


def _fail_once(
    patch: pytest.MonkeyPatch,
    owner: type,
    name: str,
    when: str,
    error: BaseException,
    *,
    number: int = 1,
    matching: str = "",
    ready: list | None = None,
) -> list:
    """Make a method fail at one call; return a list that is not empty after a call that matches."""
    original, calls = getattr(owner, name), []

    def failing(self, *args: object, **kwargs: object) -> object:
        matches = (not matching or args[1].startswith(matching)) and (ready is None or bool(ready))
        if matches:
            calls.append(args)
        if matches and len(calls) == number and when == "before":
            raise error
        result = original(self, *args, **kwargs)
        if matches and len(calls) == number and when == "after":
            raise error
        return result

    patch.setattr(owner, name, failing)
    return calls


def interrupt(spool: Spool, way: str, stage: int | str, when: str) -> None:
    """Deliver until the power is cut at a stage."""
    with failing_at(way, stage, when, PowerCutError()), pytest.raises(PowerCutError):
        deliver_all(spool, 1)
    gc.collect()  # cursors of the failed transaction, which lock the database; a process that is killed has none


@pytest.fixture(scope="module")
def expected(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """Content of a run that was delivered without interruption."""
    database = tmp_path_factory.mktemp("expected") / "mlflow.db"
    copy_database(empty_database, database)
    record(tracker_at(database), *LONG)
    client = MlflowClient(f"sqlite:///{database}")
    (run,) = runs(client)
    return content_of(client, run)


LONG = learned("task.trials=400")


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize(("way", "stage"), STAGES)
def test_an_interrupted_delivery_is_continued(way: str, stage: int | str, when: str, tracker, spool, client, expected):
    tracker.record(*LONG)
    interrupt(spool, way, stage, when)
    assert spool.pending() == [point_name(LONG[0].fingerprint)]
    before = runs(client) if client.get_experiment_by_name("design points") else []
    statuses = [run.info.status for run in before]
    # Directly, it is there completely or not at all.
    assert statuses in ([], ["FINISHED"], *([["RUNNING"]] if way == "client" else []))
    if statuses == ["FINISHED"]:
        assert content_of(client, before[0]) == expected
    with pytest.MonkeyPatch.context() as patch:
        if way == "client":
            patch.setattr(database_tables, "REVISIONS", frozenset())
        deliver_all(spool, 1)
    assert spool.pending() == []
    (run,) = runs(client)
    assert content_of(client, run) == expected


@pytest.mark.parametrize(("way", "stage"), STAGES)
def test_a_transient_error_is_retried(way: str, stage: int | str, tracker, spool, client, expected: tuple):
    tracker.record(*LONG)
    problems: list[str | None] = []
    with failing_at(way, stage, "after", ConnectionError("the connection was reset")):
        delivery = Delivery(spool, problems.append, Event(), first_pause=0.01)
        with closing(delivery):
            delivery.run_until_empty(60)
    assert problems == [None, "the connection was reset", None]
    (run,) = runs(client)
    assert content_of(client, run) == expected


def test_a_run_begun_by_the_client_is_recorded_anew_and_closed(tracker, spool, database, client, expected: tuple):
    tracker.record(*LONG)
    interrupt(spool, "client", 1, "after")
    assert [run.info.status for run in runs(client)] == ["RUNNING"]
    deliver_all(spool, 1)
    tracker_at(database).wait_for_delivery()
    finished, killed = sorted(runs(client), key=lambda run: run.info.status)
    assert content_of(client, finished) == expected
    assert killed.info.status == "KILLED"


@pytest.mark.parametrize("way", ["directly", "client"])
def test_a_refused_record_is_quarantined_and_others_are_delivered(way: str, tracker, spool, client, monkeypatch):
    (bad, curves), (good, _), (other, _) = learned(), learned("seed=1"), learned("seed=2")
    refuse = refuse_by_client if way == "client" else refuse_by_database
    refuse(monkeypatch, bad.fingerprint)
    for planned in (bad, good, other):
        tracker.record(planned, curves)
    with closing(Delivery(spool, lambda problem: None, Event(), first_pause=0.01)) as delivery:
        delivery.run_until_empty(60)
    assert spool.pending() == []
    assert spool.quarantine_reason(point_name(bad.fingerprint)) == "the store refused it: not like this"
    statuses = {run.data.tags["fingerprint"]: run.info.status for run in runs(client)}
    assert statuses.pop(bad.fingerprint, None) == ("KILLED" if way == "client" else None)
    assert statuses == {good.fingerprint: "FINISHED", other.fingerprint: "FINISHED"}


def refuse_by_client(monkeypatch: pytest.MonkeyPatch, fingerprint: str) -> None:
    """Make MLflow refuse the values of a point."""
    monkeypatch.setattr(database_tables, "REVISIONS", frozenset())
    original = MlflowClient.log_batch

    def refusing(self, run_id: str, **what: object) -> None:
        if self.get_run(run_id).data.tags["fingerprint"] == fingerprint:
            raise MlflowException("not like this", INVALID_PARAMETER_VALUE)
        original(self, run_id, **what)

    monkeypatch.setattr(MlflowClient, "log_batch", refusing)


def refuse_by_database(monkeypatch: pytest.MonkeyPatch, fingerprint: str) -> None:
    """Make a database refuse the run of a point."""
    original = DatabaseRuns.add

    def refusing(self, experiment: object, new: list) -> None:
        original(self, experiment, new)
        if any(run.tags.get("fingerprint") == fingerprint for run in new):
            raise ValueError("not like this")

    monkeypatch.setattr(DatabaseRuns, "add", refusing)


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


def test_a_run_that_another_spool_is_writing_is_not_changed(tracker, spool, database: Path, client, by_client):
    planned, curves = learned()
    tracker.record(planned, curves)
    elsewhere = undelivered_tracker_at(database, spool=str(database.parent / "elsewhere"))
    elsewhere.record(planned, curves)
    interrupt(elsewhere._spool, "client", 1, "before")
    deliver_all(spool, 1)
    assert sorted(run.info.status for run in runs(client)) == ["FINISHED", "RUNNING"]


def test_a_run_of_a_dead_process_is_closed(tracker, spool, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    interrupt(spool, "client", 1, "before")
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
