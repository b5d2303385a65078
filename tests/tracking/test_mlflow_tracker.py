"""The commit mark of a run, what is found again, and summary runs of sweeps."""

from __future__ import annotations

import csv
import getpass
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.names import CURVES, CURVES_ON_DEMAND
from rl_design_space.sweep.plan import Plan
from rl_design_space.tracking import record
from tests.tracking.stores import learned, options


@pytest.fixture
def tracker(database: Path):
    return options(database).open()


@pytest.fixture
def client(database: Path):
    from mlflow import MlflowClient

    return MlflowClient(f"sqlite:///{database}")


def runs(client, experiment: str = "design points") -> list:
    return client.search_runs([client.get_experiment_by_name(experiment).experiment_id])


COMMAND = "rl-design-space study=mine world.size=4"


def plan_of(*points) -> Plan:
    return Plan(points, studies=("mine", "yours"))


def test_a_recorded_point_is_found_by_its_fingerprint(tracker):
    (one, curves), (other, _) = learned(), learned("seed=1")
    stored = tracker.record(replace(one, studies=("a",)), curves)
    found = tracker.finished([other.fingerprint, one.fingerprint])
    assert set(found) == {one.fingerprint}
    assert found[one.fingerprint].run_id == stored.run_id
    assert found[one.fingerprint].studies == stored.studies == {"a"}
    scalars = tracker.scalars(stored)
    assert {name: scalars[name] for name in curves.scalars((4, 4))} == curves.scalars((4, 4))


@pytest.mark.parametrize("status", ["RUNNING", "FAILED", "KILLED", "SCHEDULED"])
def test_only_finished_runs_count(status: str, tracker, client):
    planned, curves = learned()
    run_id = tracker.record(planned, curves).run_id
    client.update_run(run_id, status=status)
    assert tracker.finished([planned.fingerprint]) == {}
    client.set_terminated(run_id, "FINISHED")
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_run_that_somebody_deleted_does_not_count(tracker, client):
    planned, curves = learned()
    client.delete_run(tracker.record(planned, curves).run_id)
    assert tracker.finished([planned.fingerprint]) == {}


@pytest.mark.parametrize("error", [OSError("no space left"), KeyboardInterrupt()], ids=repr)
@pytest.mark.parametrize("broken", ["log_batch", "log_artifacts", "write_artifacts"])
def test_a_record_that_breaks_off_ends_failed(broken, error, tracker, client, monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object, **__: object) -> None:
        raise error

    planned, curves = learned()
    with monkeypatch.context() as patch:
        patch.setattr(record if broken == "write_artifacts" else type(client), broken, fail)
        with pytest.raises(type(error)):
            tracker.record(planned, curves)
    assert [run.info.status for run in runs(client)] == ["FAILED"]
    assert tracker.finished([planned.fingerprint]) == {}
    # And the point can be recorded again.
    tracker.record(planned, curves)
    assert sorted(run.info.status for run in runs(client)) == ["FAILED", "FINISHED"]


@pytest.fixture
def batches(client, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Values in each batch that is logged."""
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


def test_more_values_than_a_batch_may_hold_are_split_and_all_there(database: Path, client, batches: list[int]):
    planned, curves = learned("task.trials=400")
    tracker = options(database, curves=CURVES_ON_DEMAND).open()
    run_id = tracker.record(planned, curves).run_id
    assert len(batches) > 1
    assert max(batches) <= 1000
    for name in (*CURVES, *CURVES_ON_DEMAND):
        found = [metric.value for metric in client.get_metric_history(run_id, name)]
        assert found == curves.curves[name].tolist()
    run = client.get_run(run_id)
    assert run.data.params == record.params(planned)
    assert curves.scalars((4, 4)).items() <= run.data.metrics.items()


def test_a_curve_asked_for_twice_is_recorded_once(database: Path, client):
    planned, curves = learned()
    run_id = options(database, curves=["epsilon", "epsilon"]).open().record(planned, curves).run_id
    assert len(client.get_metric_history(run_id, "epsilon")) == 4


@pytest.mark.parametrize(
    ("override", "missing"),
    [("world.size=[3,4]", "total_steps_scaled"), ("task.periods=1", "total_steps_sem")],
)
def test_a_metric_that_does_not_exist_is_left_out(override: str, missing: str, tracker, client):
    planned, curves = learned(override)
    metrics = client.get_run(tracker.record(planned, curves).run_id).data.metrics
    assert missing not in metrics
    assert {"total_steps_scaled", "total_steps_sem"} - {missing} <= set(metrics)


def test_a_stored_point_joins_other_studies(tracker, client):
    planned, curves = learned()
    stored = tracker.record(replace(planned, studies=("a",)), curves)
    tracker.add_studies(stored, ("a", "b", "c"))
    found = tracker.finished([planned.fingerprint])[planned.fingerprint]
    assert found.studies == {"a", "b", "c"}
    assert found.run_id == stored.run_id
    assert len(runs(client)) == 1


def test_a_stored_point_that_is_in_the_study_is_left_alone(tracker, batches: list[int]):
    planned, curves = learned()
    stored = tracker.record(replace(planned, studies=("a", "b")), curves)
    del batches[:]
    tracker.add_studies(stored, ("b",))
    tracker.add_studies(stored, ())
    assert batches == []


def test_experiments_have_the_names_that_the_options_say(database: Path, client):
    options(database, experiment="mine", sweeps="sums").open()
    assert {experiment.name for experiment in client.search_experiments()} == {"Default", "mine", "sums"}


@pytest.mark.parametrize(("key", "name"), [("experiment", "design points"), ("sweeps", "sweeps")])
def test_a_deleted_experiment_is_told(key: str, name: str, tracker, database: Path, client):
    client.delete_experiment(client.get_experiment_by_name(name).experiment_id)
    with pytest.raises(ConfigError, match=f"tracking.{key}={name}: was deleted"):
        options(database).open()


def test_one_experiment_is_not_found_in_another(tracker, database: Path):
    planned, curves = learned()
    tracker.record(planned, curves)
    assert options(database, experiment="mine").open().finished([planned.fingerprint]) == {}


def test_location_tells_where_to_look(tracker, database: Path):
    assert str(database) in tracker.location
    assert "design points" in tracker.location


def test_values_are_stored_as_numbers(tracker, database: Path):
    # A NumPy integer would be stored as a blob, which the MLflow UI cannot show.
    planned, curves = learned()
    tracker.record(planned, curves)
    with closing(sqlite3.connect(database)) as stored:
        types = stored.execute("select distinct typeof(value), typeof(timestamp), typeof(step) from metrics").fetchall()
    assert types == [("real", "integer", "integer")]


# Where the tags come from.


def origin(tracker, client) -> dict[str, str]:
    return client.get_run(tracker.record(*learned()).run_id).data.tags


def test_the_command_is_the_source(database: Path, client):
    assert origin(options(database).open("rl-design-space seed=1"), client)["mlflow.source.name"] == (
        "rl-design-space seed=1"
    )


def test_without_a_checkout_there_is_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    monkeypatch.setattr("rl_design_space.tracking.mlflow_tracker.CONF", tmp_path / "conf")
    assert "mlflow.source.git.commit" not in origin(options(database).open(), client)


def test_a_checkout_without_git_installed_has_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    (tmp_path / ".git").mkdir()
    monkeypatch.setattr("rl_design_space.tracking.mlflow_tracker.CONF", tmp_path / "conf")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "mlflow.source.git.commit" not in origin(options(database).open(), client)


@pytest.mark.parametrize("error", [KeyError, OSError])
def test_a_user_without_a_name_can_record(error: type[Exception], database: Path, client, monkeypatch):
    # As in a container that runs under a number only; which error it is depends on the version of Python.
    def unknown() -> str:
        raise error("No username set in the environment")

    monkeypatch.setattr(getpass, "getuser", unknown)
    assert origin(options(database).open(), client)["fingerprint"]


# Summary runs.


def test_a_sweep_has_a_summary_run_with_its_plan(tracker, client):
    points = [learned(override)[0] for override in ("seed=0", "exploration=linear")]
    summary = tracker.open_sweep(plan_of(*points), COMMAND)
    (run,) = runs(client, "sweeps")
    assert run.info.status == "RUNNING"
    assert run.info.run_name == "mine,yours"
    assert run.data.tags["study.mine"] == run.data.tags["study.yours"] == "true"
    assert COMMAND in run.data.tags["mlflow.note.content"]
    summary.close("FINISHED", {"already": 1, "done": 2, "failed": 0}, {})
    (run,) = runs(client, "sweeps")
    assert run.info.status == "FINISHED"
    assert run.data.metrics == {"points/already": 1, "points/done": 2, "points/failed": 0}
    folder = Path(run.info.artifact_uri.removeprefix("file://"))
    assert [path.name for path in folder.iterdir()] == ["plan.csv"]
    with (folder / "plan.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["fingerprint"] for row in rows] == [planned.fingerprint for planned in points]
    # A column for every parameter of any point, empty where a point does not have it.
    assert [(row["exploration"], row["exploration.k"], row["exploration.epsilon"]) for row in rows] == [
        ("constant", "", "0.1"),
        ("linear", "0.03", ""),
    ]


@pytest.mark.parametrize("status", ["FAILED", "KILLED"])
def test_a_summary_run_tells_what_failed(status: str, tracker, client):
    summary = tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    summary.close(status, {"failed": 1}, {"rl-design-space world.size=4": 'ValueError("a, b\nc")'})
    (run,) = runs(client, "sweeps")
    assert run.info.status == status
    path = Path(run.info.artifact_uri.removeprefix("file://")) / "failures.csv"
    with path.open(encoding="utf-8", newline="") as file:
        assert list(csv.DictReader(file)) == [
            {"command": "rl-design-space world.size=4", "error": 'ValueError("a, b\nc")'}
        ]


# Others, and what they leave behind.


def test_a_run_whose_process_is_gone_is_closed_at_the_next_start(tracker, database: Path, client):
    planned, curves = learned()
    with pytest.MonkeyPatch.context() as patch:
        # As if the process had been killed right before the commit mark, or had stayed.
        patch.setattr(type(client), "set_terminated", lambda *_: None)
        run_id = tracker.record(planned, curves).run_id
        summary = tracker.open_sweep(plan_of(planned), COMMAND)
    claims = tracker._claims
    claims.take(planned.fingerprint)
    options(database).open()
    # Somebody is still at them: nothing happens.
    assert [run.info.status for run in (*runs(client), *runs(client, "sweeps"))] == ["RUNNING", "RUNNING"]
    claims.release(planned.fingerprint)
    claims.release(client.get_run(summary._run_id).data.tags["rl_design_space.sweep"])
    options(database).open()
    for run in (*runs(client), *runs(client, "sweeps")):
        assert run.info.status == "KILLED"
        assert run.info.end_time
        assert run.data.tags["rl_design_space.incomplete"] == "the process that wrote it has ended"
    assert {run.info.run_id for run in runs(client)} == {run_id}


@pytest.mark.parametrize("tag", ["rl_design_space.host", "fingerprint"])
def test_a_run_of_another_machine_or_of_somebody_else_is_left_alone(tag: str, tracker, database: Path, client):
    run_id = tracker.record(*learned()).run_id
    client.update_run(run_id, status="RUNNING")
    if tag == "fingerprint":
        client.delete_tag(run_id, tag)
    else:
        client.set_tag(run_id, tag, "elsewhere")
    options(database).open()
    assert client.get_run(run_id).info.status == "RUNNING"


def test_what_another_tracker_records_is_known_when_it_is_claimed(tracker, database: Path):
    planned, curves = learned()
    assert tracker.finished([planned.fingerprint]) == {}
    assert tracker.recorded_meanwhile(planned.fingerprint) is None
    stored = options(database).open().record(planned, curves)
    found = tracker.recorded_meanwhile(planned.fingerprint)
    assert found is not None
    assert found.run_id == stored.run_id


def test_a_record_that_breaks_off_is_not_taken_for_one(tracker, monkeypatch: pytest.MonkeyPatch):
    planned, curves = learned()
    tracker.finished([])
    set_terminated = type(tracker._client).set_terminated

    def fail(self, run_id: str, status: str) -> None:
        set_terminated(self, run_id, "FAILED")
        raise OSError("no space left")

    with monkeypatch.context() as patch:
        patch.setattr(type(tracker._client), "set_terminated", fail)
        with pytest.raises(OSError, match="no space left"):
            tracker.record(planned, curves)
    # It was announced, but the store is asked.
    assert tracker._claims.announced(planned.fingerprint)
    assert tracker.recorded_meanwhile(planned.fingerprint) is None


def test_claims_of_a_server_lie_where_all_processes_of_the_user_find_them(monkeypatch, tmp_path: Path):
    from rl_design_space.tracking.mlflow_tracker import _claims_path

    monkeypatch.setattr("rl_design_space.tracking.mlflow_tracker.gettempdir", lambda: str(tmp_path))
    one, same, other = (_claims_path(uri) for uri in ("http://a:5000", "http://a:5000", "http://b:5000"))
    assert one == same != other
    assert one.is_relative_to(tmp_path)
    assert _claims_path(f"sqlite:///{tmp_path}/x.db") == tmp_path / "x.db.claims"
