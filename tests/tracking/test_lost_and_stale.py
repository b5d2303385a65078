"""Runs that vanish, runs that no process will finish, and experiments that were deleted."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from threading import Event
from types import SimpleNamespace

import pytest
from mlflow import MlflowClient

from rl_design_space.errors import ConfigError
from rl_design_space.tracking import database_tables
from rl_design_space.tracking.delivery import Delivery, deliver_all
from rl_design_space.tracking.spool import Record, Spool, point_name
from rl_design_space.tracking.tracker import SweepEnding
from tests.tracking.stores import (
    COMMAND,
    copy_database,
    learned,
    options,
    plan_of,
    record,
    runs,
    tracker_at,
    undelivered_tracker_at,
)

ENDING = SweepEnding("FINISHED", "1 learned", {"done": 1}, {}, {})


@pytest.fixture(params=["directly", "client"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """How records are written: directly, or with MLflow's client as into a database of an unknown schema."""
    if request.param == "client":
        monkeypatch.setattr(database_tables, "REVISIONS", frozenset())
    return request.param


# Runs that are RUNNING.


@pytest.fixture
def dead_sweep(database: Path) -> Spool:
    """The spool of a sweep that has died before anything was delivered."""
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    sweep = tracker.open_sweep(plan_of(planned), COMMAND)
    tracker.record(planned, curves)
    tracker._locks.release(sweep._key)
    return tracker._spool


def test_a_sweep_that_died_before_its_beginning_was_delivered_is_closed(way: str, dead_sweep: Spool, client):
    assert deliver_all(dead_sweep, 1) == ""
    (sweep,) = runs(client, "sweeps")
    assert (sweep.info.status, bool(sweep.info.end_time)) == ("KILLED", True)
    assert sweep.data.tags["rl_design_space.incomplete"] == "the process that wrote it has ended"
    assert [run.info.status for run in runs(client)] == ["FINISHED"]


def test_a_spool_is_known_on_another_host_and_in_another_place(database: Path, tmp_path: Path, client, monkeypatch):
    tracker = undelivered_tracker_at(database)
    sweep = tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    deliver_all(tracker._spool, 1)
    assert [run.info.status for run in runs(client, "sweeps")] == ["RUNNING"]
    tracker._locks.release(sweep._key)
    before, moved = tracker._spool, tmp_path / "moved"
    before.folder.rename(moved)
    monkeypatch.setattr("platform.node", lambda: "another-host")
    assert Spool(moved).identity == "spool-" + Spool(moved).identity.removeprefix("spool-")
    assert deliver_all(Spool(moved), 1) == ""
    Spool(moved).write(Record("tidy", "1", {}))
    assert deliver_all(Spool(moved), 1) == ""
    assert [run.info.status for run in runs(client, "sweeps")] == ["KILLED"]
    assert not before.folder.exists()


def test_any_spool_closes_a_dead_sweep_of_a_shared_database(database: Path, tmp_path: Path, client):
    tracker = undelivered_tracker_at(database)
    sweep = tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    deliver_all(tracker._spool, 1)
    elsewhere = tracker_at(database, spool=str(tmp_path / "elsewhere"))
    elsewhere.wait_for_delivery()
    assert [run.info.status for run in runs(client, "sweeps")] == ["RUNNING"]
    tracker._locks.release(sweep._key)
    elsewhere.wait_for_delivery()
    assert [run.info.status for run in runs(client, "sweeps")] == ["KILLED"]
    # What its own spool still holds has the last word.
    sweep.close(ENDING)
    deliver_all(tracker._spool, 1)
    (run,) = runs(client, "sweeps")
    assert run.info.status == "FINISHED"
    assert "rl_design_space.incomplete" not in run.data.tags


def test_spools_that_hold_the_same_point_record_it_once(way: str, database: Path, tmp_path: Path, client):
    planned, curves = learned()
    spools = []
    for name in ("one", "other"):
        tracker = undelivered_tracker_at(database, spool=str(tmp_path / name))
        tracker.record(planned, curves)
        spools.append(tracker._spool)
    for spool in spools:
        assert deliver_all(spool, 1) == ""
    assert len(runs(client)) == 1


# Runs that vanish.


def test_a_run_that_is_removed_before_the_end_is_reported(database: Path, client):
    tracker = tracker_at(database)
    (one, curves), (other, _) = learned(), learned("seed=1")
    for planned in (one, other):
        tracker.record(planned, curves)
    assert tracker.wait_for_delivery().lost == {}
    third, _ = learned("seed=2")
    tracker.record(third, curves)
    client.delete_run(tracker.finished([third.fingerprint])[third.fingerprint].run_id)
    (lost,) = tracker.wait_for_delivery().lost.items()
    assert lost[0] == third.fingerprint
    assert "not in the store any more" in lost[1]


def test_a_database_that_is_replaced_is_opened_again(database: Path, empty_database: Path):
    tracker = undelivered_tracker_at(database)
    (one, curves), (other, _) = learned(), learned("seed=1")
    problems: list[str | None] = []
    delivery = Delivery(tracker._spool, problems.append, Event(), first_pause=0.01)
    tracker.record(one, curves)
    delivery.run_until_empty(10)
    database.unlink()
    copy_database(empty_database, database)
    tracker.record(other, curves)
    delivery.run_until_empty(10)
    delivery.close()
    assert [problem for problem in problems if problem] == [f"{database}: was removed or replaced"]
    found = {run.data.tags["fingerprint"] for run in runs(MlflowClient(f"sqlite:///{database}"))}
    assert found == {other.fingerprint}


# Experiments that were deleted.


@pytest.mark.parametrize(("key", "name"), [("experiment", "design points"), ("sweeps", "sweeps")])
def test_a_deleted_experiment_is_reported_before_anything_is_learned(key: str, name: str, database: Path, client):
    tracker = tracker_at(database)
    tracker.record(*learned())
    tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    number = client.get_experiment_by_name(name).experiment_id
    client.delete_experiment(number)
    restore = f"MLFLOW_TRACKING_URI=sqlite:///{database} mlflow experiments restore --experiment-id {number}"
    message = re.escape(f"tracking.{key}={name}: was deleted in this store; use another name, or restore it with: ")
    again = tracker_at(database)
    with pytest.raises(ConfigError, match=f"^{message}{re.escape(restore)}$"):
        again.finished([]) if key == "experiment" else again.open_sweep(plan_of(learned()[0]), COMMAND)


def test_a_single_point_does_not_need_the_experiment_of_the_sweeps(database: Path, client):
    tracker_at(database).open_sweep(plan_of(learned()[0]), COMMAND)
    client.delete_experiment(client.get_experiment_by_name("sweeps").experiment_id)
    planned, curves = learned()
    assert record(tracker_at(database), planned, curves).run_id


def test_points_are_delivered_while_the_experiment_of_the_sweeps_is_deleted(way: str, database: Path, client):
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    sweep = tracker.open_sweep(plan_of(planned), COMMAND)
    deliver_all(tracker._spool, 1)
    number = client.get_experiment_by_name("sweeps").experiment_id
    client.delete_experiment(number)
    tracker.record(planned, curves)
    sweep.close(ENDING)
    with pytest.raises(ConfigError, match=r"tracking\.sweeps=sweeps: was deleted"):
        deliver_all(tracker._spool, 1)
    assert [run.info.status for run in runs(client)] == ["FINISHED"]
    assert [name.split("-")[1] for name in tracker._spool.pending()] == ["close"]
    client.restore_experiment(number)
    assert deliver_all(tracker._spool, 1) == ""
    assert [run.info.status for run in runs(client, "sweeps")] == ["FINISHED"]


# What a store refuses.


def test_refused_records_are_tried_again(database: Path):
    tracker = undelivered_tracker_at(database)
    (refused, curves), (corrupted, _) = learned(), learned("seed=1")
    spool = tracker._spool
    for planned, reason in ((refused, "the store refused it: too long"), (corrupted, "record is corrupted")):
        tracker.record(planned, curves)
        spool.quarantine(point_name(planned.fingerprint), reason)
    assert spool.restore_refused() == 1
    assert spool.pending() == [point_name(refused.fingerprint)]
    assert len(spool.quarantined()) == 1
    assert spool.restore_refused() == 0


def test_long_names_are_cut(way: str, database: Path, client):
    planned, curves = learned()
    tracker = tracker_at(database)
    record(tracker, replace(planned, names=SimpleNamespace(name=lambda parameters: "x" * 300)), curves)
    (run,) = runs(client)
    assert len(run.info.run_name) == 250
    assert run.info.run_name.startswith("xxx")
    assert "… sha256:" in run.info.run_name


def test_files_that_the_store_does_not_have_are_sent_again(database: Path, client, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(database_tables, "REVISIONS", frozenset())
    original, calls = MlflowClient.log_artifacts, []

    def forgetful(self, run_id: str, folder: str) -> None:
        calls.append(run_id)
        if len(calls) > 1:
            original(self, run_id, folder)

    monkeypatch.setattr(MlflowClient, "log_artifacts", forgetful)
    tracker = undelivered_tracker_at(database)
    tracker.record(*learned())
    assert deliver_all(tracker._spool, 5) == ""
    assert len(calls) == 2
    (run,) = runs(client)
    assert {file.path for file in client.list_artifacts(run.info.run_id)} == {"config.yaml", "curve.svg", "periods.npz"}


def test_the_limits_of_a_server_follow_from_the_patience(monkeypatch: pytest.MonkeyPatch, database: Path):
    monkeypatch.delenv("MLFLOW_HTTP_REQUEST_TIMEOUT", raising=False)
    options(database, patience=6.0).open()
    assert os.environ["MLFLOW_HTTP_REQUEST_TIMEOUT"] == "2"


def test_a_schema_that_is_not_written_to_directly_is_named(database: Path, monkeypatch: pytest.MonkeyPatch):
    assert tracker_at(database).finished([]) == {}
    assert tracker_at(database).wait_for_delivery().note == ""
    monkeypatch.setattr(database_tables, "REVISIONS", frozenset())
    tracker = tracker_at(database)
    tracker.finished([])
    assert re.search(
        r"mlflow\.db: its schema \w+ is not one that .* recorded by MLflow's client", tracker.wait_for_delivery().note
    )
