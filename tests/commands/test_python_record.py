"""Results that were measured elsewhere are recorded beside those of this package, exactly once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rl_design_space as rds
from rl_design_space.commands.words.store import main as store
from rl_design_space.run.repeat import compare
from rl_design_space.run.settings import store_of
from tests.tracking.stores import copy_database

POINT = rds.DesignPoint(task=rds.Task(periods=3, trials=4, max_steps=500), representation=rds.Direction())


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory, empty_database: Path) -> Path:
    folder = tmp_path_factory.mktemp("measured")
    copy_database(empty_database, folder / "mlflow.db")
    return folder


@pytest.fixture(scope="module")
def steps() -> np.ndarray:
    """Steps that are possible on any layout."""
    return np.full((3, 4), 400)


def recorded(outputs: Path, steps: np.ndarray, point: rds.DesignPoint = POINT, **more: Any) -> str:
    curves = {"steps": steps, "success": steps < point.task.max_steps}
    return rds.record(point, curves, outputs=outputs, **{"learner": "mine", "choices": {"learner.hidden": 64}, **more})


def test_a_result_is_recorded_once_and_marked(outputs: Path, steps: np.ndarray, capsys: pytest.CaptureFixture[str]):
    run = recorded(outputs, steps, studies=["fig1"])
    same = replace(POINT, exploration=rds.Linear(), learner=rds.QLearning(alpha=0.5))  # which do not count
    assert recorded(outputs, steps, same) == run
    others = {
        recorded(outputs, steps + 1, learner="theirs"),
        recorded(outputs, steps, choices={"exploration": "softmax", "exploration.temperature": 0.1}),
        recorded(outputs, steps, replace(POINT, seed=1)),
    }
    assert len(others | {run}) == 4
    runs = rds.load_runs(outputs=str(outputs))
    mine = runs.loc[run]
    assert (mine["learner"], mine["learner.hidden"], mine["representation"]) == ("mine", 64, "direction")
    assert (mine["total_steps"], mine["failed_trials"], mine["studies"]) == (1600, 0, "fig1")
    assert runs["exploration"].dropna().tolist() == ["softmax"]
    assert "learner.alpha" not in runs
    assert rds.load_periods(runs, run)["steps"].tolist() == steps.tolist()
    store(["status", "--check", f"outputs={outputs}"])  # files and params fit together
    assert "damaged" not in capsys.readouterr().out


def test_nothing_but_its_own_program_can_repeat_it(outputs: Path, steps: np.ndarray):
    reader = store_of([f"outputs={outputs}"]).reader()
    with pytest.raises(rds.ConfigError, match="was measured by mine, a program of yours"):
        compare(reader, recorded(outputs, steps), 1)


def test_another_result_under_the_same_name_is_refused(outputs: Path, steps: np.ndarray):
    run = recorded(outputs, steps)
    with pytest.raises(rds.ConfigError, match=f"recorded already, with another result \\(run {run}\\)"):
        recorded(outputs, steps + 1)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"steps": np.full((3, 5), 400)}, "steps is 3 × 5: should be 3 × 4, periods × trials of the point"),
        ({"steps": np.full((3, 4), 400.5)}, "steps is of type float64: should be whole numbers"),
        ({"steps": np.full((3, 4), 1)}, "period 0, trial 0: 1 steps are fewer than the start and goals of this period"),
        ({"steps": np.full((3, 4), 501)}, "period 0, trial 0: 501 steps are more than task.max_steps=500"),
        ({"learner": "q_learning"}, "learner=q_learning: a learner of this package"),
        ({"learner": ""}, "learner=: should be the name of your learner"),
        ({"choices": {"hidden": 3}}, "choices: hidden: the choices of a learner begin with learner."),
        ({"choices": {"learner.net": object}}, "choices: learner.net=.*: should be a plain value"),
        ({"overrides": ["tracking=none"]}, "tracking=none: nothing would be recorded"),
        ({"overrides": ["seed=3"]}, "seed=3: not a setting"),
    ],
)
def test_what_is_refused(outputs: Path, steps: np.ndarray, changed: dict[str, Any], said: str):
    with pytest.raises(rds.ConfigError, match=said):
        recorded(outputs, **{"steps": steps, **changed})


def test_a_trial_that_missed_the_goal_counts_the_step_cap(steps: np.ndarray, tmp_path: Path):
    with pytest.raises(rds.ConfigError, match=r"400 steps without success: should be task\.max_steps=500"):
        rds.record(POINT, {"steps": steps, "success": steps > 500}, learner="mine", outputs=tmp_path)
    with pytest.raises(rds.ConfigError, match="curves: steps: should be steps and success"):
        rds.record(POINT, {"steps": steps}, learner="mine", outputs=tmp_path)
