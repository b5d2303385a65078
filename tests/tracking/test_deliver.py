"""Delivery: exactly once, wherever it breaks off."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Event

import pytest

from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.spool import Spool, point_name
from rl_design_space.tracking.tracker import SweepEnding
from rl_design_space.tracking.writer import Writer, deliver_all
from tests.tracking.stores import learned, options, record, tracker_at


class Nobody:
    """Delivers nothing."""

    def watch(self, name: str, done: object) -> None:
        pass


@pytest.fixture
def client(database: Path):
    from mlflow import MlflowClient

    return MlflowClient(f"sqlite:///{database}")


@pytest.fixture
def tracker(database: Path) -> MlflowTracker:
    return options(database).open("rl-design-space", Nobody())


@pytest.fixture
def spool(tracker: MlflowTracker) -> Spool:
    return tracker._spool


def runs(client, experiment: str = "design points") -> list:
    return client.search_runs([client.get_experiment_by_name(experiment).experiment_id])


def content_of(client, run) -> tuple:
    """Everything that a run holds but its id and times."""
    names = sorted(run.data.metrics)
    history = {name: [(m.step, m.value) for m in client.get_metric_history(run.info.run_id, name)] for name in names}
    folder = Path(run.info.artifact_uri.removeprefix("file://"))
    files = {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}
    tags = {name: value for name, value in run.data.tags.items() if name != "rl_design_space.spool"}
    return run.info.status, run.data.params, history, tags, {name: files[name] for name in sorted(files)}


class PowerCutError(BaseException):
    """Ends everything at once."""


#: Calls that writing a point makes, in their order; `log_batch` twice, because there are many values.
CALLS = ("create_run", "log_batch", "log_batch", "log_artifacts", "set_terminated")


def broken_at(client, call: str, number: int, when: str, error: BaseException) -> Iterator[None]:
    """While it lasts, a call of the client breaks, once, before or after it has done its work."""
    original, count = getattr(type(client), call), 0

    def breaking(self, *args: object, **kwargs: object) -> object:
        nonlocal count
        count += 1
        if count == number and when == "before":
            raise error
        result = original(self, *args, **kwargs)
        if count == number and when == "after":
            raise error
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(client), call, breaking)
        yield


@pytest.fixture(scope="module")
def expected(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """A run as it should be."""
    from mlflow import MlflowClient

    from tests.tracking.stores import copy_database

    database = tmp_path_factory.mktemp("expected") / "mlflow.db"
    copy_database(empty_database, database)
    record(tracker_at(database), *LONG)
    client = MlflowClient(f"sqlite:///{database}")
    (run,) = runs(client)
    return content_of(client, run)


LONG = learned("task.trials=400")


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("stage", range(len(CALLS)))
def test_a_delivery_that_breaks_off_is_gone_on_with(stage: int, when: str, tracker, spool, client, expected: tuple):
    call, number = CALLS[stage], CALLS[: stage + 1].count(CALLS[stage])
    tracker.record(*LONG)
    for _ in broken_at(client, call, number, when, PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(spool, 1)
    assert spool.waiting() == [point_name(LONG[0].fingerprint)]
    before = runs(client) if client.get_experiment_by_name("design points") else []
    statuses = [run.info.status for run in before]
    assert statuses in ([], ["RUNNING"], ["FINISHED"])
    if statuses == ["FINISHED"]:
        assert content_of(client, before[0]) == expected
    deliver_all(spool, 1)
    assert spool.waiting() == []
    (run,) = runs(client)
    assert content_of(client, run) == expected


@pytest.mark.parametrize("stage", range(len(CALLS)))
def test_an_error_of_the_moment_is_tried_again(stage: int, tracker, spool, client, expected: tuple, monkeypatch):
    monkeypatch.setattr("rl_design_space.tracking.writer._FIRST_PAUSE", 0.01)
    call, number = CALLS[stage], CALLS[: stage + 1].count(CALLS[stage])
    tracker.record(*LONG)
    told: list[str | None] = []
    for _ in broken_at(client, call, number, "after", ConnectionError("the connection was reset")):
        Writer(spool, told.append, Event()).run_until_empty(60)
    assert told == [None, "the connection was reset", None]
    (run,) = runs(client)
    assert content_of(client, run) == expected


def test_a_record_that_the_store_refuses_is_set_aside_and_others_go_on(tracker, spool, client, monkeypatch):
    monkeypatch.setattr("rl_design_space.tracking.writer._FIRST_PAUSE", 0.01)
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
    deliver_all(spool, 1)
    assert spool.waiting() == []
    assert spool.why_aside(point_name(bad.fingerprint)) == "refused: not like this"
    assert {run.data.tags["fingerprint"]: run.info.status for run in runs(client)} == {
        bad.fingerprint: "KILLED",
        good.fingerprint: "FINISHED",
    }


def test_a_damaged_record_is_set_aside_and_others_go_on(tracker, spool, client):
    (bad, curves), (good, _) = learned(), learned("seed=1")
    for planned in (bad, good):
        tracker.record(planned, curves)
    (spool.folder / point_name(bad.fingerprint)).write_bytes(b"PK nonsense")
    deliver_all(spool, 1)
    assert spool.waiting() == []
    assert spool.why_aside(point_name(bad.fingerprint)).startswith("damaged: is not what")
    assert [run.data.tags["fingerprint"] for run in runs(client)] == [good.fingerprint]


def test_a_point_that_another_spool_has_delivered_is_not_doubled(tracker, spool, database: Path, client):
    planned, curves = learned()
    tracker.record(replace(planned, studies=("a",)), curves)
    elsewhere = tracker_at(database, spool=str(database.parent / "elsewhere"))
    record(elsewhere, replace(planned, studies=("b",)), curves)
    deliver_all(spool, 1)
    (run,) = runs(client)
    assert {"study.a", "study.b"} <= set(run.data.tags)


def test_a_run_that_another_spool_is_writing_is_left_alone(tracker, spool, database: Path, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    elsewhere = options(database, spool=str(database.parent / "elsewhere")).open("", Nobody())
    elsewhere.record(planned, curves)
    for _ in broken_at(client, "log_batch", 1, "before", PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(elsewhere._spool, 1)
    deliver_all(spool, 1)
    assert sorted(run.info.status for run in runs(client)) == ["FINISHED", "RUNNING"]


def test_what_a_dead_process_has_left_is_closed(tracker, spool, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    for _ in broken_at(client, "log_batch", 1, "before", PowerCutError()):
        with pytest.raises(PowerCutError):
            deliver_all(spool, 1)
    # Somebody has emptied the spool.
    spool.remove(point_name(planned.fingerprint))
    deliver_all(spool, 1)
    (run,) = runs(client)
    assert run.info.status == "KILLED"
    assert run.info.end_time
    assert run.data.tags["rl_design_space.incomplete"] == "the process that wrote it has ended"


def summary_of(tracker: MlflowTracker):
    return tracker.open_sweep(Plan((learned()[0],), studies=("mine",)), "the command")


def test_the_summary_of_a_sweep_that_lives_stays_open(tracker, spool, client):
    summary = summary_of(tracker)
    deliver_all(spool, 1)
    # Another process starts.
    deliver_all(Spool(spool.folder), 1)
    assert [run.info.status for run in runs(client, "sweeps")] == ["RUNNING"]
    tracker._claims.release(summary._key)
    deliver_all(Spool(spool.folder), 1)
    assert [run.info.status for run in runs(client, "sweeps")] == ["KILLED"]


@pytest.mark.parametrize("delivered", [True, False])
def test_a_sweep_that_has_ended_is_closed_as_it_says(tracker, spool, client, delivered: bool):
    summary = summary_of(tracker)
    if delivered:
        deliver_all(spool, 1)
    summary.close(SweepEnding("FAILED", "1 failed", {"failed": 1}, {}, {}))
    # Its claim is gone, but how it ended is known.
    deliver_all(spool, 1)
    (run,) = runs(client, "sweeps")
    assert run.info.status == "FAILED"
    assert run.data.metrics == {"points/failed": 1}
    assert run.info.start_time == summary._content["started"]


def test_a_deleted_run_makes_its_point_missing(database: Path, client):
    planned, curves = learned()
    tracker = tracker_at(database)
    client.delete_run(record(tracker, planned, curves).run_id)
    assert tracker.finished([planned.fingerprint]) == {}
    again = record(tracker, planned, curves)
    assert [run.info.run_id for run in runs(client)] == [again.run_id]
