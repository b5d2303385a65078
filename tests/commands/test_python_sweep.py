"""Sweeps from Python, from a script and from a notebook."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from jupyter_client.manager import start_new_kernel

import rl_design_space as rds
from rl_design_space.plan.planner import Planner
from tests.command_runner import PATIENCE
from tests.tracking.stores import copy_database

SMALL = rds.DesignPoint(task=rds.Task(periods=2, trials=3))
POINTS = [replace(SMALL, representation=each) for each in (rds.AdHoc(), rds.Direction(), rds.AdHoc())]
NOTEBOOK = """
from dataclasses import replace
import rl_design_space as rds
point = rds.DesignPoint(task=rds.Task(periods=2, trials=3))
result = rds.sweep([point, replace(point, seed=1)], ["tracking=none"], outputs={outputs!r})
print(len(result.scalars), "points")
"""


@dataclass(frozen=True)
class Broken:
    """A schedule that fails."""

    __version__ = 1

    def schedule(self, trials: int) -> np.ndarray:
        raise RuntimeError("no schedule")


@pytest.fixture
def outputs(tmp_path: Path, empty_database: Path) -> Path:
    copy_database(empty_database, tmp_path / "out" / "mlflow.db")
    return tmp_path / "out"


def test_points_are_recorded_once_and_as_a_command_records_them(
    outputs: Path, planner: Planner, capsys: pytest.CaptureFixture[str]
):
    result = rds.sweep(POINTS, outputs=outputs)
    assert "sweep: 2 points, 2 learned now" in str(result)
    assert str(result) in capsys.readouterr().out.replace("\n", " ")
    assert result.failed == {}
    runs = result.runs()
    assert runs["representation"].tolist() == ["ad_hoc", "direction"]
    assert runs["total_steps"].tolist() == [each["total_steps"] for each in result.scalars if each]
    assert rds.load_curves(runs, ["steps/mean"])["trial"].tolist() == [0, 1, 2] * 2
    again = rds.sweep([*POINTS, replace(SMALL, seed=1)], outputs=outputs, progress=False)
    assert again.outcome.counts == {"already": 2, "done": 1, "elsewhere": 0, "failed": 0, "left": 0}
    assert capsys.readouterr().out == ""
    typed = ["task.periods=2", "task.trials=3", "representation=direction"]
    assert runs["fingerprint"].tolist()[1] == planner(typed).fingerprint


def test_a_study_by_name(capsys: pytest.CaptureFixture[str]):
    result = rds.sweep("fig2", ["tracking=none", "task.periods=1", "task.trials=2", "threads=2"])
    assert len(result.scalars) == len(result.plan) > 1
    assert result.plan.studies == ("fig2",)
    assert "1 learned now" not in capsys.readouterr().out


def test_a_point_that_fails_does_not_stop_the_others():
    points = [replace(SMALL, exploration=Broken()), SMALL]
    result = rds.sweep(points, ["tracking=none"], progress=False)
    assert [scalars is None for scalars in result.scalars] == [True, False]
    (reason,) = result.failed.values()
    assert "no schedule" in reason


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: rds.sweep("tabel4"), "study=tabel4: no such option; did you mean study=table4"),
        (lambda: rds.sweep("multiverse2", ["hydra/launcher=joblib"]), "hydra/launcher=joblib: for the command line"),
        (lambda: rds.sweep("claims", ["study=fig1"]), "study=fig1: for the command line"),
        (lambda: rds.sweep([SMALL], ["task.periods=3"]), "task.periods=3: not a setting; change the points"),
        (lambda: rds.sweep(SMALL), r"sweep\(a DesignPoint\): should be the name of a study or a list of points"),
        (lambda: rds.sweep([SMALL, "table4"]), "point 2=table4: should be a DesignPoint"),
        (lambda: rds.sweep([]), "no design points to learn"),
        (lambda: rds.sweep([SMALL], ["threads=0"]), "threads=0"),
        (lambda: rds.sweep([SMALL], ["tracking=none"], progress=False).runs(), "tracking=none: nothing is recorded"),
    ],
)
def test_what_is_refused(call: Callable[[], object], said: str):
    with pytest.raises(rds.ConfigError, match=said):
        call()


def test_within_a_running_event_loop():
    async def steps() -> list[float]:
        return [each["total_steps"] for each in rds.sweep([SMALL], ["tracking=none"], progress=False).scalars if each]

    assert asyncio.run(steps()) == [rds.simulate(SMALL).total_steps.mean()]


def test_in_a_notebook(tmp_path: Path):
    manager, client = start_new_kernel(startup_timeout=PATIENCE)
    printed: list[str] = []
    try:
        code = NOTEBOOK.format(outputs=str(tmp_path / "out"))
        reply = client.execute_interactive(
            code, timeout=PATIENCE, output_hook=lambda message: printed.append(str(message["content"]))
        )
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    assert reply["content"]["status"] == "ok", printed
    text = "".join(printed)
    assert "2 points, 2 learned now" in text
    assert "2 points" in text
    assert "stderr" not in text
