"""Summary runs of sweeps: their plan, outcome and best points."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from rl_design_space.tracking.tracker import StoredRun, SweepEnding
from tests.tracking.stores import COMMAND, learned, plan_of, runs


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
    # The note shows the axes of the plan and no other choice.
    assert "| rank | exploration.epsilon | total_steps |" in run.data.tags["mlflow.note.content"]
