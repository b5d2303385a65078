"""The MLflow tracker: what it records, and what it finds again."""

from __future__ import annotations

import errno
import getpass
import sqlite3
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND
from rl_design_space.tracking import database_tables
from rl_design_space.tracking.record import params
from rl_design_space.tracking.spool import Spool, point_name
from tests.tracking.stores import COMMAND, learned, plan_of, record, runs, tracker_at, undelivered_tracker_at


def test_a_recorded_point_is_found_by_its_fingerprint(tracker):
    (one, curves), (other, _) = learned(), learned("seed=1")
    stored = record(tracker, replace(one, studies=("a",)), curves)
    found = tracker.finished([other.fingerprint, one.fingerprint])
    assert set(found) == {one.fingerprint}
    assert found[one.fingerprint].run_id == stored.run_id
    assert found[one.fingerprint].studies == stored.studies == {"a"}
    assert found[one.fingerprint].scalars == curves.scalars((4, 4))


@pytest.mark.parametrize("status", ["RUNNING", "FAILED", "KILLED", "SCHEDULED"])
def test_only_finished_runs_count(status: str, tracker, client):
    planned, curves = learned()
    run_id = record(tracker, planned, curves).run_id
    client.update_run(run_id, status=status)
    assert tracker.finished([planned.fingerprint]) == {}
    client.set_terminated(run_id, "FINISHED")
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_deleted_run_does_not_count(tracker, client):
    planned, curves = learned()
    client.delete_run(record(tracker, planned, curves).run_id)
    assert tracker.finished([planned.fingerprint]) == {}


@pytest.fixture
def batches(client, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Number of values in each batch that MLflow's client logs, as into a database of an unknown schema."""
    monkeypatch.setattr(database_tables, "REVISIONS", frozenset())
    sizes: list[int] = []
    log_batch = type(client).log_batch

    def counted(self, run_id, metrics=(), params=(), tags=(), **others):
        sizes.append(len(metrics) + len(params) + len(tags))
        return log_batch(self, run_id, metrics=metrics, params=params, tags=tags, **others)

    monkeypatch.setattr(type(client), "log_batch", counted)
    return sizes


def test_a_point_is_one_batch(tracker, batches: list[int]):
    planned, curves = learned("task.trials=100")
    tracker.record(planned, curves)
    assert len(batches) == 1


def test_values_that_exceed_a_batch_are_split_into_several(database: Path, client, batches: list[int]):
    planned, curves = learned("task.trials=400")
    tracker = tracker_at(database, curves=CURVES_ON_DEMAND)
    run_id = record(tracker, planned, curves).run_id
    assert len(batches) > 1
    assert max(batches) <= 1000
    for name in (*CURVES, *CURVES_ON_DEMAND):
        found = [metric.value for metric in client.get_metric_history(run_id, name)]
        assert found == curves.curves[name].tolist()
    run = client.get_run(run_id)
    assert run.data.params == params(planned.parameters)
    assert curves.scalars((4, 4)).items() <= run.data.metrics.items()


def test_a_curve_named_twice_is_recorded_once(database: Path, client):
    planned, curves = learned()
    run_id = record(tracker_at(database, curves=["epsilon", "epsilon"]), planned, curves).run_id
    assert len(client.get_metric_history(run_id, "epsilon")) == 4


@pytest.mark.parametrize(
    ("override", "missing"),
    [("world.size=[3,4]", "total_steps_scaled"), ("task.periods=1", "total_steps_sem")],
)
def test_a_metric_that_does_not_exist_is_left_out(override: str, missing: str, tracker, client):
    planned, curves = learned(override)
    metrics = client.get_run(record(tracker, planned, curves).run_id).data.metrics
    assert missing not in metrics
    assert {"total_steps_scaled", "total_steps_sem"} - {missing} <= set(metrics)


def test_a_stored_point_joins_other_studies(tracker, client):
    planned, curves = learned()
    stored = record(tracker, replace(planned, studies=("a",)), curves)
    tracker.add_studies({planned.fingerprint: stored}, {planned.fingerprint: ("a", "b", "c")})
    found = tracker.finished([planned.fingerprint])[planned.fingerprint]
    assert found.studies == {"a", "b", "c"}
    assert found.run_id == stored.run_id
    assert len(runs(client)) == 1


def test_a_stored_point_that_is_in_the_study_is_not_changed(tracker, batches: list[int]):
    planned, curves = learned()
    stored = record(tracker, replace(planned, studies=("a", "b")), curves)
    del batches[:]
    for studies in ({planned.fingerprint: ("b",)}, {planned.fingerprint: ()}, {}):
        tracker.add_studies({planned.fingerprint: stored}, studies)
    assert batches == []


def test_experiments_have_the_names_in_the_options(database: Path, client):
    tracker = tracker_at(database, experiment="mine", sweeps="sums")
    tracker.record(*learned())
    tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    assert {experiment.name for experiment in client.search_experiments()} == {"Default", "mine", "sums"}


@pytest.mark.parametrize(("key", "name"), [("experiment", "design points"), ("sweeps", "sweeps")])
def test_a_deleted_experiment_is_reported(key: str, name: str, tracker, database: Path, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    tracker.open_sweep(plan_of(planned), COMMAND)
    client.delete_experiment(client.get_experiment_by_name(name).experiment_id)
    again = tracker_at(database)
    use = partial(again.finished, []) if key == "experiment" else partial(again.open_sweep, plan_of(planned), COMMAND)
    with pytest.raises(ConfigError, match=f"tracking.{key}={name}: was deleted"):
        use()


def test_a_point_is_not_found_in_another_experiment(tracker, database: Path):
    planned, curves = learned()
    tracker.record(planned, curves)
    assert tracker_at(database, experiment="mine").finished([planned.fingerprint]) == {}


def test_the_location_names_the_store_and_the_experiment(tracker, database: Path):
    assert str(database) in tracker.location
    assert "design points" in tracker.location


def test_values_are_stored_as_numbers(tracker, database: Path):
    # A NumPy integer would be stored as a blob, which the MLflow UI cannot show.
    planned, curves = learned()
    tracker.record(planned, curves)
    with closing(sqlite3.connect(database)) as stored:
        types = stored.execute("select distinct typeof(value), typeof(timestamp), typeof(step) from metrics").fetchall()
    assert types == [("real", "integer", "integer")]


# The origin of runs.


def tags_of_a_run(tracker, client) -> dict[str, str]:
    return client.get_run(record(tracker, *learned()).run_id).data.tags


def test_the_command_is_the_source(database: Path, client):
    assert tags_of_a_run(tracker_at(database, "rl-design-space seed=1"), client)["mlflow.source.name"] == (
        "rl-design-space seed=1"
    )


def test_without_a_checkout_there_is_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    monkeypatch.setattr("rl_design_space.tracking.origin.CONF", tmp_path / "conf")
    assert "mlflow.source.git.commit" not in tags_of_a_run(tracker_at(database), client)


def test_a_checkout_without_git_installed_has_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    (tmp_path / ".git").mkdir()
    monkeypatch.setattr("rl_design_space.tracking.origin.CONF", tmp_path / "conf")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "mlflow.source.git.commit" not in tags_of_a_run(tracker_at(database), client)


@pytest.mark.parametrize("error", [KeyError, OSError])
def test_a_user_without_a_name_can_record(error: type[Exception], database: Path, client, monkeypatch):
    # As in a container whose user id has no name; the type of the error depends on the version of Python.
    def unknown() -> str:
        raise error("No username set in the environment")

    monkeypatch.setattr(getpass, "getuser", unknown)
    assert tags_of_a_run(tracker_at(database), client)["fingerprint"]


# Pending records, and other processes.


def test_a_point_that_another_tracker_has_recorded_meanwhile_is_found(tracker, database: Path):
    planned, curves = learned()
    assert tracker.finished([planned.fingerprint]) == {}
    assert tracker.recorded_since(planned.fingerprint) is None
    tracker_at(database).record(planned, curves)
    found = tracker.recorded_since(planned.fingerprint)
    assert found is not None
    assert found.run_id


def test_a_pending_record_counts_as_recorded(database: Path):
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    planned = replace(planned, studies=("a",))
    assert tracker.lock(planned.fingerprint)
    tracker.record(planned, curves)
    # It stays locked until its record is delivered.
    tracker.unlock(planned.fingerprint)
    assert not tracker.lock(planned.fingerprint)
    for other in (tracker, undelivered_tracker_at(database)):
        assert other.recorded_since(planned.fingerprint) is not None
        found = other.finished([planned.fingerprint])[planned.fingerprint]
        assert (found.run_id, found.studies, found.scalars) == ("", {"a"}, curves.scalars((4, 4)))


def test_a_corrupted_record_is_quarantined_and_does_not_count(database: Path):
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    tracker.record(planned, curves)
    path = tracker._spool.folder / point_name(planned.fingerprint)
    path.write_bytes(path.read_bytes()[:-100])
    assert tracker.finished([planned.fingerprint]) == {}
    assert not path.exists()
    assert [quarantined.name.endswith(path.name) for quarantined in tracker._spool.quarantined()] == [True]
    tracker.record(planned, curves)
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_record_is_written_when_a_full_disk_has_space_again(database: Path, monkeypatch: pytest.MonkeyPatch):
    tracker = undelivered_tracker_at(database)
    planned, curves = learned()
    write, attempts = Spool.write, []

    def full_at_first(self: Spool, written: object) -> None:
        attempts.append(written)
        if len(attempts) < 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, written)

    monkeypatch.setattr(Spool, "write", full_at_first)
    tracker.record(planned, curves)
    assert len(attempts) == 3
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_disk_that_stays_full_is_reported(database: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    tracker = undelivered_tracker_at(database, patience=0.05)
    monkeypatch.setattr(Spool, "write", full)
    for _ in range(2):
        with pytest.raises(ConfigError, match="No space left on device; free some space"):
            tracker.record(*learned())
