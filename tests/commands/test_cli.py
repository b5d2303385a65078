"""Whole runs through the real commands; each takes seconds, so tests share them."""

from __future__ import annotations

import csv
import shlex
import signal
import sys
from pathlib import Path

import pytest

from tests.command_runner import Command, Completed, commands_in, finished, next_line, runs, started, wait_until
from tests.tracking.stores import copy_database

SMALL = ("task.periods=3", "task.trials=5")
SMALL_TABLE = (*SMALL, "world.size=10,20", "task.goals=1")

OWN_MODULE = """
import sys
import threading
from dataclasses import dataclass
import numpy as np
from rl_design_space.design import Torus, cell_count

@dataclass(frozen=True)
class Blind:
    def observation(self, world, goals):
        return np.zeros((*goals.shape, cell_count(world)), dtype=np.int64)

class Fragile(Torus):
    def next_cell(self):
        if self.size == 5:
            raise RuntimeError("the floor of [5] is gone")
        return super().next_cell()

class Endless(Torus):
    def next_cell(self):
        if self.size == 5 and threading.current_thread() is not threading.main_thread():  # which plans
            print("endless", file=sys.stderr, flush=True)
            threading.Event().wait(600)
        return super().next_cell()
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the current folder of all commands."""
    return tmp_path_factory.mktemp("commands")


@pytest.fixture(scope="module")
def command(folder: Path, empty_database: Path) -> Command:
    run = commands_in(folder)
    copy_database(empty_database, folder / "out" / "mlflow.db")
    (folder / "own" / "mine.py").write_text(OWN_MODULE, encoding="utf-8")
    return run


@pytest.fixture(scope="module")
def default_run(command: Command) -> Completed:
    # Hydra then runs the job in its outputs; paths stay relative to the folder of the command.
    return command("rl-design-space", *SMALL, "hydra.job.chdir=true", cold=True)


@pytest.fixture(scope="module")
def small_table(default_run: Completed, command: Command) -> Completed:
    return command("rl-design-space", "study=table4", *SMALL_TABLE)


def test_a_point_prints_its_choices_and_its_result(default_run: Completed, folder: Path):
    lines = [line.strip() for line in default_run.stdout.splitlines()]
    assert default_run.stderr == ""
    assert not (folder / "out" / "out").exists()
    for beginning in (
        "world                        torus (size=10)",
        "representation               ad_hoc",
        "exploration                  constant (epsilon=0.1)",
        "msa                          none (lengths=[] propagation=primitives reward=realised sub_goal=continue",
        "reward                       many_rewards (step=-0.1 sub_goal=1.0 final_goal=10.0)",
        "learner                      q_learning (alpha=0.1",
        "task                         goals=3 trials=5 periods=3 max_steps=10000",
        "seed                         0",
        "fingerprint                  ",
        "total steps a period         ",
        "failed                       ",
        "final steps over optimum     ",
        "rate                         ",
        "MLflow run                   ",
    ):
        assert [line for line in lines if line.startswith(beginning)], beginning
    assert "sqlite:///out/mlflow.db" in default_run.stdout


def test_the_same_point_is_not_learned_again(default_run: Completed, command: Command, folder: Path):
    before = runs(folder)
    again = command(sys.executable, "-m", "rl_design_space", *SMALL)
    assert "recorded earlier" in again.stdout
    assert "recorded earlier" not in default_run.stdout
    assert runs(folder) == before
    assert before.count(("trials=5 periods=3", "FINISHED")) == 1
    one, other = ([x.strip() for x in run.stdout.splitlines() if "total steps" in x] for run in (default_run, again))
    assert one == other


def test_several_values_make_several_runs_and_without_tracking_no_database(command: Command, folder: Path):
    done = command(
        "rl-design-space", "-m", *SMALL, "world.size=6,7", "tracking=none", "threads=1", outputs="out/untracked"
    )
    assert done.stdout.splitlines()[0] == "sweep: 2 of 2 points to run, 1 thread"
    assert "sweep: 2 points, 2 learned now, 0 before, 0 failed; in nowhere (tracking=none)" in done.stdout
    assert list((folder / "out" / "untracked").rglob("*.db")) == []


def test_a_study_learns_its_points(small_table: Completed, folder: Path):
    first, *progress, outcome = small_table.stdout.splitlines()
    assert first.startswith("table4: 4 of 4 points to run, ")
    assert any(line.startswith("[4/4] ") for line in progress)
    assert outcome.startswith("table4: 4 points, 4 learned now, 0 before, 0 failed; in sqlite:///out/mlflow.db")
    assert small_table.stderr == ""
    assert len([name for name, status in runs(folder) if "goals=1" in name and status == "FINISHED"]) == 4
    assert ("table4", "FINISHED") in runs(folder, "sweeps")


def test_a_complete_study_learns_nothing(small_table: Completed, command: Command, folder: Path):
    before = runs(folder), runs(folder, "sweeps")
    again = command("rl-design-space", "study=table4", *SMALL_TABLE)
    *result, outcome = again.stdout.splitlines()
    assert result[0].startswith("fewest total steps of 4 designs")
    assert outcome.startswith("table4: 4 points, 0 learned now, 4 before, 0 failed; in sqlite:///out/mlflow.db")
    assert (runs(folder), runs(folder, "sweeps")) == before


def test_a_report_is_written_from_recorded_runs(small_table: Completed, command: Command, folder: Path):
    done = command("rl-design-report", "table4", *SMALL_TABLE, cold=True)
    paths = [folder / line for line in done.stdout.splitlines()]
    assert {path.name for path in paths} == {f"table4.{suffix}" for suffix in ("png", "svg", "csv", "md")}
    assert all(path.parent == folder / "out" / "report" and path.is_file() for path in paths)
    with (folder / "out" / "report" / "table4.csv").open(encoding="utf-8") as file:
        measured = {
            (row["representation"], row["size"], row["goals"]) for row in csv.DictReader(file) if row["measured"]
        }
    assert measured == {(way, size, "1") for way in ("ad_hoc", "direction") for size in ("10", "20")}


# Errors in the configuration.


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("rl-design-space", "world.siz=5"), "world.siz: no such key in Torus; did you mean world.size?"),
        (("rl-design-space", "study=table4", "world.size=1"), "study table4, block ad_hoc: world.size=1: "),
        (("rl-design-space", "representation=null"), "representation=null: name exactly one option"),
        (("rl-design-report", "tabel4"), "study=tabel4: no such option; did you mean study=table4?"),
    ],
    ids=["point", "study", "option", "report"],
)
def test_a_configuration_error_is_one_line_with_status_two(words: tuple[str, ...], message: str, command: Command):
    done = command(*words, status=2)
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {message}")
    assert done.stdout == ""


def test_a_sweep_that_matches_nothing_is_refused(command: Command):
    done = command("rl-design-space", "-m", "representation=glob(none_such*)", "tracking=none", status=2)
    assert done.stderr == "error: representation=glob(none_such*): matches nothing\n"


def test_a_traceback_is_shown_with_hydra_full_error(command: Command):
    done = command("rl-design-space", "world.siz=5", status=1, HYDRA_FULL_ERROR="1")
    assert "Traceback (most recent call last)" in done.stderr
    assert "world.siz" in done.stderr.splitlines()[-1] or "world.siz" in done.stderr


# User components, failures and interruptions.

OWN = ("representation=ad_hoc", "representation._target_=mine.Blind", "exploration.k=0.03")


@pytest.fixture(scope="module")
def failing(default_run: Completed, command: Command) -> Completed:
    words = ("study=table4", *SMALL, *OWN, "task.goals=1", "world._target_=mine.Fragile", "world.size=4,5,6")
    return command("rl-design-space", *words, status=1, COLUMNS="80")


def test_a_failed_point_does_not_stop_the_others(failing: Completed, folder: Path):
    assert "3 points, 2 learned now, 0 before, 1 failed" in " ".join(failing.stdout.split())
    recorded = [name for name, status in runs(folder) if status == "FINISHED"]
    assert [sum(f"size={size}" in name for name in recorded) for size in (4, 5, 6)] == [1, 0, 1]
    assert runs(folder, "sweeps")[-1] == ("table4", "FAILED")


def test_a_failure_is_shown_at_once_and_again_at_the_end(failing: Completed):
    # The cells of a table are wrapped, so only short texts are found in one piece.
    at_once, _, at_the_end = failing.stdout.partition("[3/3]")
    assert "RuntimeError: the floor of [5] is gone" in at_once
    assert "Failures" in at_the_end
    assert "RuntimeError" in at_the_end
    assert "world.size=5" in at_the_end


def test_the_command_that_repeats_a_failure_can_be_copied(failing: Completed):
    begun = [line[line.index("rl-design-space") :] for line in failing.stdout.splitlines() if "rl-design-space" in line]
    expected = {"rl-design-space", *OWN, *SMALL, "task.goals=1", "world.size=5", "world._target_=mine.Fragile"}
    assert [line for line in begun if expected | {"outputs=out"} <= set(shlex.split(line))], begun


def test_the_table_of_failures_wraps_and_truncates_nothing(failing: Completed):
    # Also in a narrow terminal: long cells are wrapped, not truncated.
    _, _, table = failing.stdout.partition("Failures")
    assert "…" not in table
    assert "world._target_=mine.Fragile" in "".join(table.split())


def test_an_interrupted_study_is_killed_and_continues_later(default_run: Completed, command: Command, folder: Path):
    words = ("study=table4", *SMALL, *OWN, "task.goals=1", "world.size=5,7", "outputs=out", "threads=1")

    def recorded() -> list[tuple[str, str]]:
        return [run for run in runs(folder) if "size=7" in run[0]]

    with started(folder, *words, "world._target_=mine.Endless") as process:
        assert next_line(process, "stderr") == "endless\n"
        # The larger one was learned before; it may take a moment to be recorded.
        wait_until(lambda: "FINISHED" in dict(recorded()).values(), process)
        for _ in range(5):  # as impatient people do
            process.send_signal(signal.SIGINT)
        done = finished(process)
    assert done.returncode in (130, -signal.SIGINT), done
    assert done.stderr.splitlines()[-1].startswith("interrupted; run the same command again")
    assert "Traceback" not in done.stderr
    assert runs(folder, "sweeps")[-1] == ("table4", "KILLED")
    # What was learned before is kept.
    assert [status for _, status in recorded()] == ["FINISHED"]
