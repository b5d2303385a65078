"""Summary runs of sweeps: their plan, outcome and best points."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import grid
from rl_design_space.tracking.connection import connect
from rl_design_space.tracking.tracker import Findings, StoredRun, SweepEnding
from tests.tracking.stores import COMMAND, copy_database, learned, plan_of, record, runs, tracker_at


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
    assert "\n- running\n" in note
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
def test_a_summary_run_lists_the_failures(status: str, tracker, client):
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
    assert {row["run_id"] for row in rows} == {"id"}
    assert "| rank | run | total_steps |" in run.data.tags["mlflow.note.content"]


def test_the_leaderboard_names_the_runs_of_points_just_learned(tracker, client, tmp_path: Path):
    planned, curves = learned()
    summary = tracker.open_sweep(plan_of(planned), COMMAND)
    pending = tracker.record(planned, curves)
    assert pending.run_id == ""
    summary.close(ending(stored={planned.fingerprint: pending}))
    (run,) = runs(client, "sweeps")
    (point,) = runs(client)
    assert [row["run_id"] for row in rows_of(run, "leaderboard.csv")] == [point.info.run_id]


@pytest.mark.parametrize(
    ("points", "shape"),
    [
        ([{"reward": r, "reward.step": s, "seed": n} for r, s in (("a", 0), ("b", 1)) for n in (0, 1, 2)], "2 × 3"),
        ([{"r": r, "k": k, "size": n} for r, k in (("a", 0.03), ("b", 0.02)) for n in (10, 20)], "2 × 2"),
        ([{"k": 0.1, "l": 1}, {"k": 0.1, "l": 2}, {"k": 0.2, "l": 1}], None),
        ([{"k": 0.1}], ""),
    ],
    ids=["option", "paired", "corner missing", "one"],
)
def test_numbers_of_values_multiply_to_the_number_of_points(points: list[dict], shape: str | None):
    found = grid(points)
    assert (None if found is None else " × ".join(map(str, found.values()))) == shape


def test_the_note_says_in_what_the_points_differ(tracker, client):
    points = [learned(*words)[0] for words in (("reward=end_reward",), ("seed=1",), ())]
    shapes = {3: "3 points (not all combinations of 2 reward, 2 seed)", 1: "1 point"}
    for count, shape in shapes.items():
        tracker.open_sweep(plan_of(*points[:count]), COMMAND)
        assert any(f"{shape}\n" in run.data.tags["mlflow.note.content"] for run in runs(client, "sweeps"))


def test_a_summary_run_ranks_the_points_by_other_measures(empty_database: Path, tmp_path: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    results = [learned(f"exploration.epsilon={epsilon}") for epsilon in (0.9, 0.1)]
    # The first point is recorded by another tracker: its measures are computed from its files.
    record(tracker_at(tmp_path / "mlflow.db"), *results[0])
    tracker = tracker_at(tmp_path / "mlflow.db", leaderboard=[{"steps_after": 2, "statistic": "median"}, "trials_to"])
    record(tracker, *results[1])
    plan = plan_of(*(planned for planned, _ in results))
    stored = tracker.finished([planned.fingerprint for planned in plan])
    tracker.open_sweep(plan, COMMAND).close(ending(stored=stored))
    (sweep,) = runs(connect(f"sqlite:///{tmp_path / 'mlflow.db'}"), "sweeps")
    name = "steps_after=2,statistic=median"
    rows = {row["fingerprint"]: row for row in rows_of(sweep, "leaderboard.csv")}
    expected = {planned.fingerprint: np.median(curves.steps[:, 2:].sum(axis=1)) for planned, curves in results}
    assert {fingerprint: float(row[name]) for fingerprint, row in rows.items()} == expected
    assert [row["fingerprint"] for row in rows.values()] == sorted(expected, key=lambda each: expected[each])
    assert {row["trials_to=1.1"] for row in rows.values()} == {"≥ 4"}
    note = sweep.data.tags["mlflow.note.content"]
    assert f"**Best by {name}**" in note
    assert f"| rank | run | {name} | trials_to=1.1 | total_steps |" in note


def test_a_leaderboard_of_a_measure_that_cannot_be_imported_is_refused_at_once(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"measure no_such_module\.late: cannot be imported"):
        tracker_at(tmp_path / "mlflow.db", leaderboard=["no_such_module.late"])


def test_the_best_set_of_a_sweep_is_marked_in_its_note_and_table(tracker, client):
    points = [learned(override)[0] for override in ("seed=0", "exploration=linear")]
    stored = {planned.fingerprint: StoredRun("id", scalars={"total_steps": 5.0}) for planned in points}
    summary = tracker.open_sweep(plan_of(*points), COMMAND)
    found = Findings(
        best=frozenset([points[1].fingerprint]), lines=["race: it took less"], tables={"race.csv": b"a\n1\n"},
        metrics={"race/steps": 3.0},
    )  # fmt: skip
    summary.close(ending(stored=stored, findings=found))
    (run,) = runs(client, "sweeps")
    note = run.data.tags["mlflow.note.content"]
    assert "- race: it took less" in note
    assert "| 2 ★ |" in note
    assert "| 1 |" in note
    assert run.data.metrics == {"race/steps": 3}
    assert [row["in_best_set"] for row in rows_of(run, "leaderboard.csv")] == ["False", "True"]
    assert "race.csv" in files_of(run)
