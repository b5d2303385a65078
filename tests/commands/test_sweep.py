"""Sweeps through the real command line: plans, shards, several studies, failures."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from tests.command_runner import Command, commands_in, runs
from tests.tracking.stores import copy_database

SMALL = ("task.periods=2", "task.trials=3")

MINE = """
blocks:
  a: {world.size: "4,5,6", task.goals: "1,2", task.periods: 2, task.trials: 3}
constraints:
  crowded: {drop: world.size < 5 and task.goals > 1, why: too many goals for so few cells}
"""
YOURS = 'blocks: {a: {world.size: "6,7", task.goals: 1, task.periods: 2, task.trials: 3}}'
FRAGILE = """
from rl_design_space.design import Torus

class Fragile(Torus):
    def next_cell(self):
        raise RuntimeError(f"no floor in {self.size}")
"""
CONFIG = ("--config-dir", "own/conf")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the current folder of all commands."""
    return tmp_path_factory.mktemp("sweeps")


@pytest.fixture(scope="module")
def command(folder: Path) -> Command:
    """Run a command, with user studies and a user module."""
    run = commands_in(folder)
    studies = folder / "own" / "conf" / "study"
    studies.mkdir(parents=True)
    (studies / "mine.yaml").write_text(MINE, encoding="utf-8")
    (studies / "yours.yaml").write_text(YOURS, encoding="utf-8")
    (folder / "own" / "fragile.py").write_text(FRAGILE, encoding="utf-8")
    return run


@pytest.fixture(scope="module")
def new_store(folder: Path, empty_database: Path) -> Callable[[str], str]:
    """Give outputs an empty database, because a command takes seconds to create one."""

    def create(outputs: str) -> str:
        copy_database(empty_database, folder / outputs / "mlflow.db")
        return outputs

    return create


def last_line(text: str) -> str:
    return text.splitlines()[-1]


def test_a_plan_is_shown_and_nothing_runs(command: Command, folder: Path):
    done = command("rl-design-space", *CONFIG, "study=mine,yours", "plan=true", outputs="out/planned")
    lines = [" ".join(line.split()) for line in done.stdout.splitlines()]
    assert "world.size 4 4 (1) 5 (2) 6 (2) 7 (1)" in lines
    assert "task.goals 2 1 (4) 2 (2)" in lines
    assert [line for line in lines if line[:1] in "0123456789-=" and line][:4] == [
        "8 combinations",
        "- 1 dropped by crowded of mine: too many goals for so few cells",
        "- 1 duplicate of other points",
        "= 6 points",
    ]
    about = r"0 recorded already, 6 to run: about \S+ s on \d+ cores? \(learning \S+ s, recording \S+ s\)"
    assert any(re.fullmatch(about, line) for line in lines), lines
    assert not (folder / "out" / "planned").exists()


def test_several_studies_share_their_points(command: Command, new_store: Callable[[str], str], folder: Path):
    done = command("rl-design-space", *CONFIG, "study=mine,yours", outputs=new_store("out/studies"))
    assert last_line(done.stdout).startswith("mine,yours: 6 points, 6 learned now, 0 before, 0 failed")
    assert [status for _, status in runs(folder, outputs="out/studies")] == ["FINISHED"] * 6
    assert runs(folder, "sweeps", outputs="out/studies") == [("mine,yours", "FINISHED")]
    # One of them alone has nothing left to do, and a plan says so.
    again = command("rl-design-space", *CONFIG, "study=yours", outputs="out/studies")
    assert last_line(again.stdout).startswith("yours: 2 points, 0 learned now, 2 before")
    plan = command("rl-design-space", *CONFIG, "study=mine", "task.goals=1,3", "plan=true", outputs="out/studies")
    assert "3 recorded already, 2 to run" in plan.stdout


def test_shards_run_every_point_once(command: Command, new_store: Callable[[str], str]):
    outputs = new_store("out/shards")
    sweep = ("rl-design-space", "-m", *SMALL, "world.size=range(4,11)")
    learned = [
        int(last_line(command(*sweep, f"shard={i}/2", outputs=outputs).stdout).split(" learned now")[0].split()[-1])
        for i in (1, 2)
    ]
    assert sum(learned) == 7
    assert "7 before" in command(*sweep, outputs=outputs).stdout
    plan = command("rl-design-space", "-m", "task.trials=3", "world.size=4,12", "plan=true", outputs=outputs).stdout
    assert "- 1 begins with periods that are recorded" in plan


def test_one_block_can_be_left_out(command: Command):
    done = command("rl-design-space", "study=table4", "~study.blocks.direction", "plan=true")
    assert "= 9 points" in done.stdout
    assert "representation" not in done.stdout


def test_on_error_stop_stops_at_the_first_failure(command: Command, new_store: Callable[[str], str], folder: Path):
    words = ("-m", *SMALL, "world._target_=fragile.Fragile", "seed=range(0,50)", "on_error=stop", "threads=1")
    done = command("rl-design-space", *words, status=1, outputs=new_store("out/stopped"))
    assert "RuntimeError: no floor in 10" in done.stdout
    assert "stopped at the first failure; to continue: rl-design-space -m task.periods=2" in done.stdout
    (outcome,) = [line for line in done.stdout.splitlines() if line.startswith("sweep: 50 points")]
    assert "0 learned now" in outcome
    assert "not run" in outcome
    assert runs(folder, "sweeps", outputs="out/stopped") == [("sweep", "FAILED")]


def test_failures_are_recorded_with_the_summary_run(command: Command, new_store: Callable[[str], str], folder: Path):
    words = ("-m", *SMALL, "world._target_=fragile.Fragile", "world.size=4,5")
    command("rl-design-space", *words, status=1, outputs=new_store("out/failed"))
    (path,) = (folder / "out" / "failed").rglob("failures.csv")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["error"].split(" (")[0] for row in rows} == {f"RuntimeError: no floor in {size}" for size in (4, 5)}
    assert all("fragile.py:" in row["error"] for row in rows)
    assert all(row["command"].startswith("rl-design-space task.periods=2") for row in rows)
    assert all("outputs=out/failed" in row["command"] for row in rows)


def test_points_have_files_of_their_own_only_with_dumps(command: Command, folder: Path):
    sweep = ("rl-design-space", "-m", *SMALL, "world.size=4,5", "tracking=none")
    command(*sweep, outputs="out/bare")
    assert not (folder / "out" / "bare").exists() or not list((folder / "out" / "bare").rglob("*"))
    command(*sweep, "hydra.launcher.dumps=true", outputs="out/dumped")
    dumps = sorted((folder / "out" / "dumped" / "points").iterdir())
    assert len(dumps) == 2
    for dump in dumps:
        assert len(dump.name) == 64
        config = yaml.safe_load((dump / "config.yaml").read_text(encoding="utf-8"))
        overrides = yaml.safe_load((dump / "overrides.yaml").read_text(encoding="utf-8"))
        assert f"world.size={config['world']['size']}" in overrides
        assert config["world"]["_target_"] == "rl_design_space.design.world.Torus"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-m", "threads=1,2"), "threads: a setting applies to the whole sweep; give it one value"),
        (("-m", "seed=1", "shard=3/2"), "shard=3/2: should be i/N, from 1/N to N/N"),
        (("-m", "seed=1", "on_error=ignore"), "on_error=ignore: should be 'continue' or 'stop'"),
        (("-m", "seed=1,x"), "seed=x: should be a valid integer"),
        (("-m", "seed=1", "exploration.k=0.1"), "exploration.k: no such key in Constant"),
        (("study=table4,tabel3",), "study=tabel3: no such option; did you mean study=table"),
        (("study=table4", "-m", "--cfg", "job"), "--multirun and --cfg cannot be used together"),
        (("plan=maybe",), "plan=maybe: should be a valid boolean"),
        (("-m", "seed=1", "hydra.launcher.dump=true"), "hydra.launcher.dump"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_errors_in_a_sweep_are_reported_before_any_point_runs(words, message: str, command: Command, folder: Path):
    done = command("rl-design-space", *words, status=2, outputs="out/mistakes")
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {message}")
    assert done.stdout == ""
    assert not (folder / "out" / "mistakes").exists()
