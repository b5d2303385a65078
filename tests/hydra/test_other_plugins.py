"""Other sweepers and launchers than ours: whole runs through the real command give identical results."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
import yaml

from tests.command_runner import PATIENCE, Completed, completed
from tests.tracking.stores import copy_database

SMALL = ("task.periods=2", "task.trials=3")
SWEEP = ("-m", *SMALL, "representation=ad_hoc,direction", "world.size=4,5")
#: Arguments that select other sweepers and launchers.
OTHERS = {
    "basic sweeper, basic launcher": ("hydra/sweeper=basic", "hydra/launcher=basic"),
    "basic launcher": ("hydra/launcher=basic",),
    "basic sweeper": ("hydra/sweeper=basic",),
    "joblib": ("hydra/launcher=joblib", "hydra.launcher.n_jobs=2"),
    "basic sweeper, joblib": ("hydra/sweeper=basic", "hydra/launcher=joblib", "hydra.launcher.n_jobs=2"),
}
TUNING = (
    *("-m", *SMALL, "hydra/sweeper=optuna", "hydra.sweeper.n_trials=4", "hydra.sweeper.n_jobs=2"),
    *("hydra.sweeper.sampler.seed=1", "exploration=linear", "exploration.k=interval(0.01,0.1)"),
)
FAILING = ("-m", *SMALL, "hydra/sweeper=basic", "world._target_=mine.Fragile")
OWN_MODULE = """
from rl_design_space.design import Torus

class Fragile(Torus):
    def next_cell(self):
        if self.size == 5:
            raise RuntimeError("the floor of [5] is gone")
        return super().next_cell()
"""
COMMANDS = {
    "default": SWEEP,
    **{name: (*SWEEP, *words) for name, words in OTHERS.items()},
    "study": (
        "study=table4",
        *SMALL,
        "world.size=10",
        "task.goals=1",
        "hydra/launcher=joblib",
        "hydra.launcher.n_jobs=1",
    ),
    "total_steps": TUNING,
    # In a folder of its own, which nothing else creates.
    "final_steps_over_optimum": (*TUNING, "objective=final_steps_over_optimum", "hydra.sweep.dir=found"),
    "unknown objective": (*TUNING, "objective=final_step"),
    "away": (*TUNING, "tracking=server", "tracking.uri=http://127.0.0.1:9", "tracking.patience=1"),
    "failing": (*FAILING, "world.size=4,5,6"),
    "empty": ("-m", *SMALL, *OTHERS["basic sweeper, joblib"], "representation=direction", "seed=range(3,3)"),
}


@dataclass(frozen=True)
class Run:
    """The recorded run of a point."""

    tags: dict[str, str]
    params: dict[str, str]
    metrics: dict[tuple[str, int], float]
    periods: dict[str, np.ndarray]


@dataclass(frozen=True)
class Done:
    """A completed command and its outputs."""

    completed: Completed
    outputs: Path

    def runs(self) -> dict[str, Run]:
        """Return the complete runs of points, by fingerprint."""
        assert self.completed.returncode in (0, 1), self.completed.stdout + self.completed.stderr
        query = (
            "select run_uuid, artifact_uri from runs join experiments using (experiment_id) "
            "where experiments.name = 'design points' and status = 'FINISHED'"
        )
        with closing(sqlite3.connect(self.outputs / "mlflow.db")) as database:
            found = [self._run(database, *row) for row in database.execute(query)]
        runs = {run.tags["fingerprint"]: run for run in found}
        assert len(runs) == len(found), "a point was recorded twice"
        return runs

    def _run(self, database: sqlite3.Connection, run_id: str, artifacts: str) -> Run:
        tags = database.execute("select key, value from tags where run_uuid = ?", [run_id])
        params = database.execute("select key, value from params where run_uuid = ?", [run_id])
        metrics = database.execute("select key, step, value from metrics where run_uuid = ?", [run_id])
        with np.load(Path(unquote(urlsplit(artifacts).path)) / "periods.npz") as archive:
            periods = dict(archive)
        return Run(dict(tags), dict(params), {(key, step): value for key, step, value in metrics}, periods)


@pytest.fixture(scope="module")
def done(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[str], Done]]:
    """Run the commands by name, each with its own outputs; two at a time, because each takes seconds to start."""
    folder = tmp_path_factory.mktemp("plugins")
    (folder / "temporary").mkdir()
    (folder / "own").mkdir()
    (folder / "own" / "mine.py").write_text(OWN_MODULE, encoding="utf-8")

    def run(name: str) -> Done:
        outputs = name.replace(" ", "_").replace(",", "")
        copy_database(empty_database, folder / outputs / "mlflow.db")
        words = (*COMMANDS[name], f"outputs={outputs}", "threads=1")
        return Done(completed(folder, "rl-design-space", *words, MLFLOW_HTTP_REQUEST_MAX_RETRIES="0"), folder / outputs)

    with ThreadPoolExecutor(2) as pool:
        futures: dict[str, Future[Done]] = {name: pool.submit(run, name) for name in COMMANDS}
        yield lambda name: futures[name].result(timeout=len(COMMANDS) * PATIENCE)
        pool.shutdown(cancel_futures=True)


def untimed(metrics: dict[tuple[str, int], float]) -> dict[tuple[str, int], float]:
    return {name: value for name, value in metrics.items() if name[0] != "env_steps_per_second"}


@pytest.mark.parametrize("name", OTHERS)
def test_results_do_not_depend_on_the_sweeper_or_launcher(name: str, done: Callable[[str], Done]):
    expected, got = done("default").runs(), done(name).runs()
    assert done(name).completed.returncode == 0
    assert got.keys() == expected.keys()
    assert len(expected) == 4
    for fingerprint, run in expected.items():
        other = got[fingerprint]
        assert other.params == run.params
        assert untimed(other.metrics) == untimed(run.metrics) != {}
        assert other.periods.keys() == run.periods.keys() != set()
        for array, values in run.periods.items():
            np.testing.assert_array_equal(other.periods[array], values, err_msg=array, strict=True)


def test_points_of_another_launcher_belong_to_their_study(done: Callable[[str], Done]):
    runs = done("study").runs()
    assert done("study").completed.returncode == 0
    assert len(runs) == 2
    assert all("study.table4" in run.tags for run in runs.values())


@pytest.mark.parametrize("objective", ["total_steps", "final_steps_over_optimum"])
def test_optuna_finds_the_best_value_of_the_objective(objective: str, done: Callable[[str], Done]):
    runs = done(objective).runs().values()
    assert done(objective).completed.returncode == 0
    assert len(runs) == 4
    best = min(runs, key=lambda run: run.metrics[objective, 0])
    folder = done(objective).outputs
    if objective != "total_steps":
        folder = folder.parent / "found"
    result = yaml.safe_load((folder / "optimization_results.yaml").read_text(encoding="utf-8"))
    assert result["best_value"] == best.metrics[objective, 0]
    assert str(result["best_params"]["exploration.k"]) == best.params["exploration.k"]


def test_an_unknown_objective_is_refused(done: Callable[[str], Done]):
    refused = done("unknown objective").completed
    assert refused.returncode == 2
    assert "Traceback" not in refused.stderr
    # Other lines are from the sweeper, which has started by then.
    (line,) = [line for line in refused.stderr.splitlines() if line.startswith("error: ")]
    assert line.startswith("error: objective: final_step: no such measure; did you mean final_steps_over_optimum?")
    assert refused.stderr.endswith(f"{line}\n")


def test_optuna_with_an_unreachable_store_reports_pending_records(done: Callable[[str], Done]):
    away = done("away").completed
    assert away.returncode == 1
    assert "4 results of this and earlier commands safe on disk, not yet in http://127.0.0.1:9" in away.stdout
    assert "Best value" in away.stdout + away.stderr


def test_a_failed_point_fails_the_sweep_of_another_sweeper(done: Callable[[str], Done]):
    failed = done("failing").completed
    assert failed.returncode not in (0, 2), failed.stdout + failed.stderr
    assert "the floor of [5] is gone" in failed.stdout
    assert sorted(run.params["world.size"] for run in done("failing").runs().values()) == ["4", "6"]


def test_a_sweep_in_other_processes_that_matches_nothing_is_refused(done: Callable[[str], Done]):
    empty = done("empty").completed
    assert empty.returncode == 2, empty.stdout + empty.stderr
    assert empty.stderr.splitlines()[-1] == "error: seed=range(3,3): matches nothing"
