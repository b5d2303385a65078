"""Hydra's flags and tab completion: they work as in every Hydra application, without slow imports."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from rl_design_space.commands import words as command_words
from tests.command_runner import PATIENCE

#: Modules that take seconds to import and that no command here needs.
SLOW = {"mlflow", "numba", "pandas", "seaborn"}

#: The command; it writes a list of all imported modules at its end.
COMMAND = """
import atexit, os, sys
from pathlib import Path
atexit.register(lambda: Path(os.environ["IMPORTED"]).write_text("\\n".join(sys.modules)))
sys.argv[0] = "rl-design-space"
from rl_design_space.commands.cli import main
main()
"""

Completed = subprocess.CompletedProcess[str]
Command = Callable[..., Completed]


@pytest.fixture
def command(tmp_path: Path) -> Command:
    """Run the command in an empty folder; it must neither write a file nor import a slow module."""
    folder, imported = tmp_path / "empty", tmp_path / "imported"
    folder.mkdir()

    def run(*words: str, status: int = 0, **variables: str) -> Completed:
        inherited = {name: value for name, value in os.environ.items() if not name.startswith(("HYDRA_", "MLFLOW_"))}
        done = subprocess.run(
            [sys.executable, "-c", COMMAND, *words],
            cwd=folder,
            env={**inherited, "IMPORTED": str(imported), "COLUMNS": "200", "NO_COLOR": "1", **variables},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == status, done.stdout + done.stderr
        assert list(folder.iterdir()) == []
        assert SLOW & set(imported.read_text(encoding="utf-8").split()) == set()
        return done

    return run


@pytest.mark.parametrize("words", [("--help",), ("-h",), ("study=table4", "--help"), ("-m", "-h")])
def test_help_lists_commands_and_options(words: tuple[str, ...], command: Command):
    lines = [" ".join(line.split()) for line in command(*words).stdout.splitlines()]
    assert "rl-design-space study=table4 run it; the same command resumes an interrupted run" in lines
    for word, said in command_words.summaries().items():
        assert f"{word} {said}" in lines
    assert "world torus, slip, walled, wind" in lines
    assert "representation ad_hoc, aggregated, direct, direction, distance, without" in lines
    assert "msa none, controllers, length_2, length_3, length_5, lengths_2_3, lengths_2_3_5, lengths_3_5," in lines


def test_help_fits_a_terminal(command: Command):
    assert max(map(len, command("--help").stdout.splitlines())) <= 120


def test_help_lists_user_options(command: Command, tmp_path: Path):
    (tmp_path / "mine" / "world").mkdir(parents=True)
    (tmp_path / "mine" / "world" / "moebius.yaml").write_text("_target_: mine.Moebius\n", encoding="utf-8")
    lines = command("--help", "--config-dir", str(tmp_path / "mine")).stdout.splitlines()
    assert ["world", "torus,", "moebius,", "slip,", "walled,", "wind"] in [line.split() for line in lines]


def test_a_subcommand_has_its_own_help(command: Command):
    assert "usage: rl-design-space list" in command("list", "--help").stdout
    assert "usage: rl-design-space show" in command("show", "-h").stdout


def test_hydra_help_is_available(command: Command):
    assert "hydra/launcher: basic, design" in command("--hydra-help").stdout


@pytest.mark.parametrize("words", [("list",), ("show", "study=table4"), ("show", "world=torus", "--json")])
def test_list_and_show_import_nothing_slow(words: tuple[str, ...], command: Command):
    assert command(*words).stdout


def test_the_config_of_a_job_is_shown(command: Command):
    config = yaml.safe_load(command("--cfg", "job", "world=walled", "world.size=5").stdout)
    assert config["world"] == {"_target_": "rl_design_space.design.Walled", "size": 5}
    assert config["task"]["goals"] == 3
    assert "hydra" not in config


def test_the_config_of_hydra_is_shown(command: Command):
    config = yaml.safe_load(command("--cfg", "hydra").stdout)["hydra"]
    assert config["sweeper"]["_target_"] == "hydra_plugins.rl_design_space.sweeper.DesignSweeper"
    assert config["launcher"]["_target_"] == "hydra_plugins.rl_design_space.launcher.DesignLauncher"


def test_our_plugins_are_among_those_of_hydra(command: Command):
    names = command("--info", "plugins").stdout.split()
    assert {"DesignSweeper", "DesignLauncher", "DesignDaskLauncher", "DesignRayLauncher"} <= set(names)


def test_where_the_defaults_come_from_is_shown(command: Command):
    rows = [[cell.strip() for cell in line.split("|")] for line in command("--info", "defaults").stdout.splitlines()]
    packages = {row[1]: row[2] for row in rows if len(row) > 2}
    assert packages["world/torus"] == "world"
    assert packages["hydra/sweeper/design"] == "hydra.sweeper"
    assert packages["hydra/launcher/design"] == "hydra.launcher"


@pytest.mark.parametrize(
    ("typed", "offered"),
    [("-m world=walled task.g", "task.goals=\n"), ("--config-dir nowhere world=(", "\n")],
    ids=["valid", "invalid"],
)
def test_a_shell_asks_for_completions_and_nothing_else_is_printed(typed: str, offered: str, command: Command):
    line = f"rl-design-space {typed}"
    done = command("-sc", "query=bash", COMP_LINE=f"{line} seed=1", COMP_POINT=str(len(line)))
    assert (done.stdout, done.stderr) == (offered, "")


def test_the_config_of_a_study_is_shown(command: Command):
    config = yaml.safe_load(command("study=table4", "--cfg", "job").stdout)
    assert set(config["study"]["blocks"]) == {"ad_hoc", "direction"}


@pytest.mark.parametrize(
    ("words", "points"),
    [(("plan=true",), 1), (("plan=true", "study=table4"), 18), (("plan=true", "-m", "seed=1,2"), 2)],
)
def test_a_plan_runs_nothing_and_writes_nothing(words: tuple[str, ...], points: int, command: Command):
    done = command(*words)
    assert f"0 recorded already, {points} to run" in done.stdout
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-m", "--cfg", "job"), "--multirun and --cfg cannot be used together"),
        (("study=table4", "hydra/sweeper=basic"), "study=table4 needs hydra/sweeper=design, not basic"),
        (("-m", "plan=true", "hydra/sweeper=optuna"), "plan=true needs hydra/sweeper=design, not optuna"),
        # Hydra and OmegaConf raise errors of other classes for these.
        (("=1",), "=1: "),
        (("study=5",), "study=5: "),
        (("hydra/launcher=5",), "hydra/launcher=5: "),
        (("~world=5",), "~world=5: "),
        (("-m", "msa.lengths.x=1"), "msa.lengths.x=1: "),
    ],
    ids=lambda value: value if isinstance(value, str) else " ".join(value),
)
def test_contradicting_arguments_are_refused_in_one_line_with_status_two(
    words: tuple[str, ...], message: str, command: Command
):
    done = command(*words, status=2)
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {message}")
    assert done.stdout == ""


def test_study_null_is_the_default(command: Command):
    assert command("study=null", "--cfg", "job").stdout == command("--cfg", "job").stdout
