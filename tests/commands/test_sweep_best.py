"""A sweep that ends marks the points that cannot be told from the best."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.analysis.best import best_means
from rl_design_space.commands import sweep_best
from rl_design_space.commands.sweep_best import BestPoints
from rl_design_space.commands.sweep_result import result_lines
from rl_design_space.plan.plan import Plan
from rl_design_space.run.local_executor import LocalExecutor
from rl_design_space.run.runner import run_sweep
from rl_design_space.tracking.tracker import NullTracker
from tests.tracking.stores import copy_database, import_mlflow, learned, runs, tracker_at


class Silent:
    """A display that shows nothing."""

    def __getattr__(self, name: str):
        return lambda *arguments: None


CHOICES = ("representation=ad_hoc", "representation=direction", "task.max_steps=60", "exploration.epsilon=0.9")
POINTS = [learned("task.periods=20", "exploration=constant", choice) for choice in CHOICES]
PLAN = Plan([planned for planned, _ in POINTS], studies=("mine",)).named()


def ended(tracker, plan: Plan = PLAN):
    best = BestPoints(plan, tracker, Silent())
    return run_sweep(plan, tracker, LocalExecutor(1), best, command="the command", findings=best.findings)


def expected() -> set[str]:
    import numpy as np

    inside = best_means(np.stack([curves.total_steps for _, curves in POINTS], axis=1)).inside
    return {planned.fingerprint for (planned, _), is_inside in zip(POINTS, inside, strict=True) if is_inside}


def test_ties_with_the_best_are_marked_in_the_note_and_the_terminal(empty_database: Path, tmp_path: Path):
    import_mlflow()
    from mlflow import MlflowClient

    copy_database(empty_database, tmp_path / "mlflow.db")
    tracker = tracker_at(tmp_path / "mlflow.db")
    tracker.record(*POINTS[0])  # its periods are read
    outcome = ended(tracker)
    assert outcome.already == 1
    assert outcome.findings.best == expected()
    assert 0 < len(expected()) < len(POINTS)
    (sweep,) = runs(MlflowClient(f"sqlite:///{tmp_path}/mlflow.db"), "sweeps")
    note = sweep.data.tags["mlflow.note.content"]
    assert note.count(" ★ |") == len(expected())
    assert f"](get-artifact?path=picture.svg&run_uuid={sweep.info.run_id})" in note
    lines = result_lines(PLAN, outcome.stored, (), outcome.findings.best)
    assert sum(line.startswith("  ★ ") for line in lines) == len(expected())
    assert f"★ {len(expected())} of 4 designs cannot be told from the best at 95 %" in lines


def test_points_that_cannot_be_compared_or_are_too_many_get_no_mark(monkeypatch: pytest.MonkeyPatch):
    assert ended(NullTracker()).findings.best == expected()
    seeds = Plan([*PLAN, learned("seed=1")[0]])
    assert ended(NullTracker(), seeds).findings.best is None
    assert ended(NullTracker(), replace(PLAN, points=PLAN[:1])).findings.best is None
    monkeypatch.setattr(sweep_best, "_MOST", 3)
    assert ended(NullTracker()).findings.best is None
