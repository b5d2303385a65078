"""The files and commands of docs/components.md work in an empty folder."""

from __future__ import annotations

import importlib
import re
import shlex
import sys
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from rl_design_space import contracts
from rl_design_space.design import DesignPoint
from rl_design_space.learning import checked
from tests.command_runner import Completed, completed
from tests.tracking.stores import copy_database

PAGE = (Path(__file__).parents[1] / "docs" / "components.md").read_text(encoding="utf-8")
BLOCKS = [(token.info.split(), token.content) for token in MarkdownIt().parse(PAGE) if token.type == "fence"]
FILES = {words[1]: content for words, content in BLOCKS if len(words) == 2}
COMMANDS = [line for words, content in BLOCKS if words == ["sh"] for line in content.splitlines()]
#: Kind of component, a built-in option, the option of the page.
KINDS = [
    ("representation", "ad_hoc", "rings"),
    ("exploration", "constant", "hyperbolic"),
    ("reward", "many_rewards", "even"),
    ("world", "torus", "maze"),
    ("msa", "none", "doubling"),
]
#: Those that go with primitive actions alone.
OF_ONE_STEP = [("learner", "q_learning", "impatient"), ("exploration", "constant", "streak")]


@pytest.fixture(scope="module")
def folder(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that holds the files of the page, and a database, because a command takes seconds to create one."""
    folder = tmp_path_factory.mktemp("page")
    copy_database(empty_database, folder / "outputs" / "mlflow.db")
    for name, content in FILES.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(content, encoding="utf-8")
    return folder


def run(folder: Path, *words: str) -> Completed:
    done = completed(folder, *words, TMPDIR=str(folder))
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def test_every_kind_has_a_module_and_an_option():
    options = [*KINDS, *OF_ONE_STEP]
    expected = {f"conf/{kind}/{own}.yaml" for kind, _, own in options} | {f"{own}.py" for _, _, own in options}
    assert expected <= set(FILES)
    assert len(COMMANDS) == 4


def test_the_commands_of_the_page_run(folder: Path):
    shown = [run(folder, *shlex.split(command)).stdout for command in COMMANDS]
    assert "wrote my_rings.py" in shown[0]
    assert "2 points, 2 learned now" in shown[1]
    assert "5 points, 5 learned now" in shown[2]
    assert {Path(line).name for line in shown[3].splitlines()} == {
        f"mine.{kind}" for kind in ("png", "svg", "csv", "md")
    }


@pytest.mark.parametrize("kinds", [KINDS, OF_ONE_STEP], ids=["tables", "of_one_step"])
def test_the_examples_of_the_page_are_swept_beside_built_in_options(kinds: list[tuple[str, str, str]], folder: Path):
    """Every combination of them, in one command."""
    small = ("task.periods=2", "task.trials=3", "task.goals=1", "tracking=none")
    choices = [f"{kind}={built_in},{own}" for kind, built_in, own in kinds]
    done = run(folder, "rl-design-space", "--config-dir", "conf", "-m", *choices, *small)
    points = 2 ** len(kinds)
    assert f"{points} points, {points} learned now, 0 before, 0 failed" in done.stdout
    assert done.stderr == ""


def test_the_examples_with_chance_and_with_a_potential_keep_their_contracts(
    folder: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.syspath_prepend(str(folder))
    ice, lantern = importlib.import_module("ice"), importlib.import_module("lantern")
    world = ice.Ice(rows=("...#..", ".....#"), columns=(1, 4))
    contracts.check_world(world)
    contracts.check_reward(lantern.Lantern())
    outcomes = checked.outcomes(DesignPoint(world=world))
    assert outcomes is not None
    assert outcomes.probabilities[0, :, 0].tolist() == [1.0, 0.8, 1.0, 1.0, 0.8, 1.0] * 2
    for name in ("maze", "ice", "lantern"):
        sys.modules.pop(name)


def test_the_contract_test_of_the_page_passes(folder: Path):
    assert (
        "1 passed"
        in run(folder, sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_rings.py").stdout
    )


def test_the_checks_and_kinds_that_the_page_names_exist():
    from rl_design_space.commands.words.new import KINDS as MADE

    assert set(re.findall(r"`(check_\w+)`", PAGE)) == set(contracts.__all__)
    assert set(MADE) == {kind for kind, _, _ in [*KINDS, *OF_ONE_STEP]} | {"actions", "curriculum", "study"}
