"""User components through the real commands, from a folder that contains nothing else."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.command_runner import Command, commands_in, runs

SMALL = ("task.periods=2", "task.trials=3")
HEATMAP = ("heatmap", "--rows=representation", "--cols=task.trials", "--study=mine")
WAY = """
from dataclasses import dataclass
from offsets import SHIFT
from rl_design_space.design import encode

@dataclass(frozen=True)
class Way:
    def observation(self, world, goals):
        x, _ = world.offset(goals)
        return encode((x + SHIFT) % world.shape[0], world.shape[0])
"""
STUDY = """# Mine.
blocks:
  all: {representation: "ad_hoc,way", task.periods: 2, task.trials: 3}
report:
  _target_: rl_design_space.report.CurvesFigure
  title: Mine
  shows: Two lines
  panels: [{title: one, where: {task.goals: 3}, lines: {a: {representation: ad_hoc}, b: {representation: way}}}]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The current folder. Modules and configs lie in a subfolder, so that only the config folder leads to them."""
    return tmp_path_factory.mktemp("own")


@pytest.fixture(scope="module")
def command(folder: Path, empty_database: Path) -> Command:
    run = commands_in(folder, empty_database)
    write(folder, "way.py", WAY)
    write(folder, "offsets.py", "SHIFT = 0\n")
    write(folder, "conf/representation/way.yaml", "# Mine.\n_target_: way.Way\n")
    write(folder, "conf/study/mine.yaml", STUDY)
    return lambda *words, **more: run(*words, PYTHONPATH="", **more)


def write(folder: Path, name: str, content: str) -> None:
    path = folder / "project" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, encoding="utf-8")


def sources(folder: Path, outputs: str = "out") -> list[str]:
    """Return the code identities of the recorded runs."""
    query = "select value from params where key = 'representation.source'"
    with closing(sqlite3.connect(folder / outputs / "mlflow.db")) as database:
        return [value for (value,) in database.execute(query)]


def test_a_study_is_learned_again_where_code_has_changed_and_is_reported(command: Command, folder: Path):
    named = {"RL_DESIGN_SPACE_CONFIG": "project/conf"}
    first = command("rl-design-space", "study=mine", **named)
    assert "mine: 2 points, 2 learned now, 0 before, 0 failed" in first.stdout
    assert first.stderr == ""
    write(folder, "way.py", "# A comment.\n" + WAY)
    assert "0 learned now, 2 before" in command("rl-design-space", "study=mine", **named).stdout
    write(folder, "offsets.py", "SHIFT = 1\n")
    planned = command("rl-design-space", "study=mine", "plan=true", **named).stdout
    assert "1 recorded already, 1 to run" in planned
    assert "- 1 runs again, because its run has other code of representation=way\n" in planned
    assert "1 learned now, 1 before" in command("rl-design-space", "study=mine", **named).stdout
    found = sources(folder)
    assert len(set(found)) == len(found) == 2
    assert all(source.startswith("sha256:") for source in found)
    report = command("rl-design-report", "mine", "--config-dir", "project/conf")
    assert {Path(line).name for line in report.stdout.splitlines()} >= {"mine.png", "mine.csv"}
    drawn = command("rl-design-report", "--config-dir", "project/conf", *HEATMAP)
    text = (folder / Path(drawn.stdout.splitlines()[-1])).read_text(encoding="utf-8")
    assert f"Made by `rl-design-report --config-dir project/conf {' '.join(HEATMAP)} " in text
    note = "eft out: 1 of 3 runs, recorded with earlier code of representation=way"
    assert f"L{note}." in text
    told, heading, *numbers = drawn.stderr.splitlines()
    assert told == f"l{note}; to include them, name their code, as in --rows representation.source"
    assert heading.startswith("total_steps by ")
    assert numbers[0].startswith("  Least: ")
    differ = command("rl-design-report", *HEATMAP, "--filter=params.`representation.source` like '%'", status=2)
    assert differ.stderr.startswith("error: representation.source: 2 runs of one cell ")
    nothing = command("rl-design-report", "mine", "task.trials=99", "-cd", "project/conf", status=2)
    assert "study mine: none of its 2 points is recorded; `rl-design-space --config-dir project/conf " in nothing.stderr
    assert "Missing" not in (folder / "out" / "report" / "mine.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("launcher", ["design_dask", "joblib"])
def test_workers_find_user_modules(launcher: str, command: Command, folder: Path):
    words = ("--config-dir", "project/conf", "-m", *SMALL, "representation=ad_hoc,way", "threads=2")
    done = command("rl-design-space", *words, f"hydra/launcher={launcher}", outputs=f"out/{launcher}")
    assert "2 points, 2 learned now, 0 before, 0 failed" in done.stdout
    assert [status for _, status in runs(folder, outputs=f"out/{launcher}")] == ["FINISHED"] * 2
    assert len(sources(folder, f"out/{launcher}")) == 1


def test_a_file_that_shadows_a_shipped_one_is_reported(command: Command, folder: Path):
    write(folder, "shadows/representation/direct.yaml", "# Mine.\n_target_: way.Way\n")
    words = ("-cd", "project/shadows", *SMALL, "representation=direct", "plan=true", "tracking=none")
    done = command("rl-design-space", *words)
    told = "project/shadows/representation/direct.yaml is used in place of the shipped file of that name"
    assert done.stderr == f"{told}\n"


@pytest.mark.parametrize(
    ("option", "module", "message"),
    [
        ("_target_: wrong.Way\nwidth: [", WAY, "project/wrong/representation/wrong.yaml:2:"),
        ("_target_: wrong.Way\nwidth: 2\n", WAY, "representation.width: no such key"),
        (
            "_target_: wrong.Way\n",
            WAY.replace("SHIFT)", "SHIFT + 0.5)"),
            "wrong.Way.observation() calls encode(digits, base=10): should be whole numbers, not float64",
        ),
        (
            "_target_: worng.Way\n",
            WAY,
            "representation._target_=worng.Way: cannot be imported: No module named 'worng'",
        ),
        ("_target_: wrong.Way\n", WAY + "]", "representation._target_=wrong.Way: cannot be imported: "),
    ],
    ids=["YAML", "key", "dtype", "module", "syntax"],
)
def test_a_mistake_is_one_message_and_status_2(option: str, module: str, message: str, command: Command, folder: Path):
    write(folder, "wrong.py", module)
    write(folder, "wrong/representation/wrong.yaml", f"{option}")
    words = ("-cd", "project/wrong", "-m", *SMALL, "representation=ad_hoc,wrong", "tracking=none")
    (line,) = command("rl-design-space", *words, status=2).stderr.splitlines()
    assert line.startswith("error: ")
    assert message in line
