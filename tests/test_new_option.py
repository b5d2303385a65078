"""A new option is a dataclass and a YAML file: everything else follows from them."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_runner import environment

ROOT = Path(__file__).parents[1]
RENEW = "-m rl_design_space.catalogue.schemas"
COPIED = ("rl_design_space", "conf", "tests", "pyproject.toml")

CLASS = '''

@dataclass(frozen=True, kw_only=True, config=STRICT)
class Stepwise:
    """ε falls to a lower level at one trial.

    Attributes:
        level: ε before and after the fall.
        fall: trial of the fall.
        after: ε after the fall: `none`, or a `tenth` of the level.
    """

    level: _Probability = 0.5
    fall: Annotated[int, Field(ge=1)] = 20
    after: Literal["none", "tenth"] = "none"

    def schedule(self, trials: int) -> FloatArray:
        return np.where(np.arange(trials) < self.fall, self.level, {"none": 0.0, "tenth": self.level / 10}[self.after])
'''
OPTION = """\
# yaml-language-server: $schema=schema.json
# ε falls to a lower level at one trial
_target_: rl_design_space.design.Stepwise
level: 0.5
fall: 20
after: none
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Copy the project, and add an exploration schedule to it."""
    tree = tmp_path_factory.mktemp("tree")
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, tree / name)
    module = tree / "rl_design_space" / "design" / "exploration.py"
    text = module.read_text(encoding="utf-8")
    assert "from typing import Annotated\n" in text
    text = text.replace("from typing import Annotated\n", "from typing import Annotated, Literal\n")
    module.write_text(text + CLASS, encoding="utf-8")
    (tree / "conf" / "exploration" / "stepwise.yaml").write_text(OPTION, encoding="utf-8")
    return tree


def python(tree: Path, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=tree,
        env=environment(tree, TMPDIR=str(tree), PYTHONPATH=str(tree)),
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_option_is_public(tree: Path):
    program = (
        "import rl_design_space as rds\n"
        "assert rds.__file__.startswith(str(__import__('pathlib').Path.cwd()))\n"
        "assert 'Stepwise' in rds.__all__\n"
        "assert rds.Stepwise is __import__('rl_design_space.design').design.Stepwise\n"
        "point = rds.DesignPoint.from_overrides(['exploration=stepwise', 'exploration.fall=2'])\n"
        "assert point == rds.DesignPoint(exploration=rds.Stepwise(fall=2))\n"
        "print(*point.exploration.schedule(3))"
    )
    assert python(tree, "-c", program).split() == ["0.5", "0.5", "0.0"]


def test_the_option_is_listed_and_shown(tree: Path):
    command = ("-m", "rl_design_space")
    listed = json.loads(python(tree, *command, "list", "exploration", "--json"))["exploration"]["options"]
    assert listed["stepwise"] == {
        "description": "ε falls to a lower level at one trial",
        "file": str(tree / "conf" / "exploration" / "stepwise.yaml"),
    }
    shown = json.loads(python(tree, *command, "show", "exploration=stepwise", "--json"))["parameters"]
    assert shown["exploration.after"]["description"] == "ε after the fall: `none`, or a `tenth` of the level."


@pytest.fixture(scope="module")
def renewed(tree: Path) -> list[str]:
    """Renew the schemas; return what the command prints."""
    return python(tree, *RENEW.split()).splitlines()


def test_the_schema_is_renewed_by_the_command_of_make_lint(renewed: list[str], tree: Path):
    assert f"\t$(BIN)/python {RENEW}\n" in (ROOT / "Makefile").read_text(encoding="utf-8")
    assert renewed == [f"wrote {tree / 'conf' / group / 'schema.json'}" for group in ("exploration", "study")]
    assert python(tree, *RENEW.split()) == ""


@pytest.mark.usefixtures("renewed")
def test_the_tests_of_options_pass_over_it(tree: Path):
    """Contract, invalid values, schema, `list` and `show`, after the schema has been renewed."""
    tests = (
        f"tests/{each}"
        for each in (
            "design",
            "catalogue/test_schemas.py",
            "commands/test_list.py",
            "commands/test_show.py",
            "test_imports.py",
        )
    )
    named = "stepwise or Stepwise or up_to_date or public or shipped_option_is_listed"
    told = python(tree, "-m", "pytest", "-v", "-p", "no:cacheprovider", *tests, "-k", named)
    for passed in (
        "test_contracts.py::test_a_shipped_option_keeps_its_contract[exploration=stepwise]",
        "test_validation.py::test_an_invalid_value_is_refused_with_the_name_of_its_field[Stepwise]",
        "test_schemas.py::test_a_shipped_file_names_its_schema_and_conforms_to_it[exploration/stepwise.yaml]",
        "test_show.py::test_every_parameter_of_a_shipped_option_is_explained[exploration=stepwise]",
    ):
        assert f"{passed} PASSED" in told
