"""What is recorded and found again, and summary runs of sweeps."""

from __future__ import annotations

import csv
import errno
import getpass
import sqlite3
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning.names import CURVES, CURVES_ON_DEMAND
from rl_design_space.sweep.plan import Plan
from rl_design_space.tracking import mlflow_tracker
from rl_design_space.tracking.claims import claims_path
from rl_design_space.tracking.mlflow_tracker import MlflowTracker
from rl_design_space.tracking.record import params
from rl_design_space.tracking.spool import Spool, point_name
from rl_design_space.tracking.tracker import StoredRun, SweepEnding
from tests.tracking.stores import learned, options, record, tracker_at


@pytest.fixture
def tracker(database: Path):
    return tracker_at(database)


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


def test_a_run_that_somebody_deleted_does_not_count(tracker, client):
    planned, curves = learned()
    client.delete_run(record(tracker, planned, curves).run_id)
    assert tracker.finished([planned.fingerprint]) == {}


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
    tracker = tracker_at(database, curves=CURVES_ON_DEMAND)
    run_id = record(tracker, planned, curves).run_id
    assert len(batches) > 1
    assert max(batches) <= 1000
    for name in (*CURVES, *CURVES_ON_DEMAND):
        found = [metric.value for metric in client.get_metric_history(run_id, name)]
        assert found == curves.curves[name].tolist()
    run = client.get_run(run_id)
    assert run.data.params == params(planned)
    assert curves.scalars((4, 4)).items() <= run.data.metrics.items()


def test_a_curve_asked_for_twice_is_recorded_once(database: Path, client):
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


def test_a_stored_point_that_is_in_the_study_is_left_alone(tracker, batches: list[int]):
    planned, curves = learned()
    stored = record(tracker, replace(planned, studies=("a", "b")), curves)
    del batches[:]
    for studies in ({planned.fingerprint: ("b",)}, {planned.fingerprint: ()}, {}):
        tracker.add_studies({planned.fingerprint: stored}, studies)
    assert batches == []


def test_experiments_have_the_names_that_the_options_say(database: Path, client):
    tracker = tracker_at(database, experiment="mine", sweeps="sums")
    tracker.record(*learned())
    tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    assert {experiment.name for experiment in client.search_experiments()} == {"Default", "mine", "sums"}


@pytest.mark.parametrize(("key", "name"), [("experiment", "design points"), ("sweeps", "sweeps")])
def test_a_deleted_experiment_is_told(key: str, name: str, tracker, database: Path, client):
    planned, curves = learned()
    tracker.record(planned, curves)
    tracker.open_sweep(plan_of(planned), COMMAND)
    client.delete_experiment(client.get_experiment_by_name(name).experiment_id)
    again = tracker_at(database)
    use = partial(again.finished, []) if key == "experiment" else partial(again.open_sweep, plan_of(planned), COMMAND)
    with pytest.raises(ConfigError, match=f"tracking.{key}={name}: was deleted"):
        use()


def test_one_experiment_is_not_found_in_another(tracker, database: Path):
    planned, curves = learned()
    tracker.record(planned, curves)
    assert tracker_at(database, experiment="mine").finished([planned.fingerprint]) == {}


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
    return client.get_run(record(tracker, *learned()).run_id).data.tags


def test_the_command_is_the_source(database: Path, client):
    assert origin(tracker_at(database, "rl-design-space seed=1"), client)["mlflow.source.name"] == (
        "rl-design-space seed=1"
    )


def test_without_a_checkout_there_is_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    monkeypatch.setattr("rl_design_space.tracking.origin.CONF", tmp_path / "conf")
    assert "mlflow.source.git.commit" not in origin(tracker_at(database), client)


def test_a_checkout_without_git_installed_has_no_commit(database: Path, client, tmp_path: Path, monkeypatch):
    (tmp_path / ".git").mkdir()
    monkeypatch.setattr("rl_design_space.tracking.origin.CONF", tmp_path / "conf")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "mlflow.source.git.commit" not in origin(tracker_at(database), client)


@pytest.mark.parametrize("error", [KeyError, OSError])
def test_a_user_without_a_name_can_record(error: type[Exception], database: Path, client, monkeypatch):
    # As in a container that runs under a number only; which error it is depends on the version of Python.
    def unknown() -> str:
        raise error("No username set in the environment")

    monkeypatch.setattr(getpass, "getuser", unknown)
    assert origin(tracker_at(database), client)["fingerprint"]


# Summary runs.


def ending(status: str = "FINISHED", **others: object) -> SweepEnding:
    return SweepEnding(**{"status": status, "verdict": "", "counts": {}, "failures": {}, "stored": {}, **others})


def rows_of(run, name: str) -> list[dict[str, str]]:
    path = Path(run.info.artifact_uri.removeprefix("file://")) / name
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def files_of(run) -> set[str]:
    return {path.name for path in Path(run.info.artifact_uri.removeprefix("file://")).iterdir()}


def test_a_sweep_has_a_summary_run_with_its_plan(tracker, client):
    points = [learned(override)[0] for override in ("seed=0", "exploration=linear")]
    summary = tracker.open_sweep(plan_of(*points), COMMAND)
    (run,) = runs(client, "sweeps")
    assert run.info.status == "RUNNING"
    assert run.info.run_name == "mine,yours"
    assert run.data.tags["study.mine"] == run.data.tags["study.yours"] == "true"
    note = run.data.tags["mlflow.note.content"]
    assert COMMAND in note
    assert "**mine,yours**: 2 points" in note
    assert "under way" in note
    summary.close(ending(verdict="2 learned now", counts={"already": 1, "done": 2, "failed": 0}))
    (run,) = runs(client, "sweeps")
    assert run.info.status == "FINISHED"
    assert run.data.metrics == {"points/already": 1, "points/done": 2, "points/failed": 0}
    assert "FINISHED: 2 learned now" in run.data.tags["mlflow.note.content"]
    assert files_of(run) == {"plan.csv"}
    rows = rows_of(run, "plan.csv")
    assert [row["fingerprint"] for row in rows] == [planned.fingerprint for planned in points]
    # A column for every parameter of any point, empty where a point does not have it.
    assert [(row["exploration"], row["exploration.k"], row["exploration.epsilon"]) for row in rows] == [
        ("constant", "", "0.1"),
        ("linear", "0.03", ""),
    ]


@pytest.mark.parametrize("status", ["FAILED", "KILLED"])
def test_a_summary_run_tells_what_failed(status: str, tracker, client):
    error = 'ValueError("a, b\nc")'
    summary = tracker.open_sweep(plan_of(learned()[0]), COMMAND)
    summary.close(ending(status, counts={"failed": 1}, failures={"rl-design-space world.size=4": error}))
    (run,) = runs(client, "sweeps")
    assert run.info.status == status
    assert rows_of(run, "failures.csv") == [{"command": "rl-design-space world.size=4", "error": error}]
    assert "`rl-design-space world.size=4`" in run.data.tags["mlflow.note.content"]


def test_a_summary_run_ranks_the_points(tracker, client):
    results = [learned(f"exploration.epsilon={epsilon}") for epsilon in (0.9, 0.1, 0.5)]
    plan = plan_of(*(planned for planned, _ in results))
    stored = {planned.fingerprint: StoredRun("id", scalars=curves.scalars((4, 4))) for planned, curves in results}
    tracker.open_sweep(plan, COMMAND).close(ending(stored=stored))
    (run,) = runs(client, "sweeps")
    rows = rows_of(run, "leaderboard.csv")
    totals = [float(row["total_steps"]) for row in rows]
    assert totals == sorted(curves.total_steps.mean() for _, curves in results)
    assert [row["rank"] for row in rows] == ["1", "2", "3"]
    best = min(results, key=lambda result: result[1].total_steps.mean())[0]
    assert rows[0]["exploration.epsilon"] == str(best.point.exploration.epsilon)
    # The note shows the axes of the plan and no other choice.
    assert "| rank | exploration.epsilon | total_steps |" in run.data.tags["mlflow.note.content"]


# Others, and what they leave behind.


def test_what_another_tracker_records_is_known_when_it_is_claimed(tracker, database: Path):
    planned, curves = learned()
    assert tracker.finished([planned.fingerprint]) == {}
    assert tracker.recorded_meanwhile(planned.fingerprint) is None
    tracker_at(database).record(planned, curves)
    found = tracker.recorded_meanwhile(planned.fingerprint)
    assert found is not None
    assert found.run_id


class Nobody:
    """Delivers nothing."""

    def watch(self, name: str, done: object) -> None:
        pass


def test_what_is_kept_and_not_yet_delivered_counts_as_recorded(database: Path):
    chosen = options(database)
    tracker = MlflowTracker(chosen, "", Nobody())
    planned, curves = learned()
    planned = replace(planned, studies=("a",))
    assert tracker.claim(planned.fingerprint)
    tracker.record(planned, curves)
    # Its claim stays until the store has it.
    tracker.release(planned.fingerprint)
    assert not tracker.claim(planned.fingerprint)
    for other in (tracker, MlflowTracker(chosen, "", Nobody())):
        assert other.recorded_meanwhile(planned.fingerprint) is not None
        kept = other.finished([planned.fingerprint])[planned.fingerprint]
        assert (kept.run_id, kept.studies, kept.scalars) == ("", {"a"}, curves.scalars((4, 4)))


def test_a_damaged_record_is_set_aside_and_does_not_count(database: Path):
    tracker = MlflowTracker(options(database), "", Nobody())
    planned, curves = learned()
    tracker.record(planned, curves)
    path = tracker._spool.folder / point_name(planned.fingerprint)
    path.write_bytes(path.read_bytes()[:-100])
    assert tracker.finished([planned.fingerprint]) == {}
    assert not path.exists()
    assert [kept.name.endswith(path.name) for kept in tracker._spool.aside()] == [True]
    tracker.record(planned, curves)
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_result_that_cannot_be_written_waits_for_room(database: Path, monkeypatch: pytest.MonkeyPatch):
    tracker = MlflowTracker(options(database), "", Nobody())
    planned, curves = learned()
    write, attempts = Spool.write, []

    def full_at_first(self: Spool, written: object) -> None:
        attempts.append(written)
        if len(attempts) < 3:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, written)

    monkeypatch.setattr(mlflow_tracker, "_PAUSE", 0.01)
    monkeypatch.setattr(Spool, "write", full_at_first)
    tracker.record(planned, curves)
    assert len(attempts) == 3
    assert set(tracker.finished([planned.fingerprint])) == {planned.fingerprint}


def test_a_disk_that_stays_full_is_told(database: Path, monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    tracker = MlflowTracker(options(database, patience=0.05), "", Nobody())
    monkeypatch.setattr(mlflow_tracker, "_PAUSE", 0.01)
    monkeypatch.setattr(Spool, "write", full)
    for _ in range(2):
        with pytest.raises(ConfigError, match="No space left on device; make room"):
            tracker.record(*learned())


def test_claims_of_a_server_lie_where_all_processes_of_the_user_find_them(monkeypatch, tmp_path: Path):
    monkeypatch.setattr("rl_design_space.tracking.claims.gettempdir", lambda: str(tmp_path))
    one, same, other = (claims_path(uri) for uri in ("http://a:5000", "http://a:5000", "http://b:5000"))
    assert one == same != other
    assert one.is_relative_to(tmp_path)
    assert claims_path(f"sqlite:///{tmp_path}/x.db") == tmp_path / "x.db.claims"
