"""The commands of docs/configs.md work as written, and its files match their schemas."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft7Validator
from omegaconf import OmegaConf

from rl_design_space._paths import CONF
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_study
from tests.documented import DOCS, File, Typed, parts_of, run
from tests.tracking.stores import copy_database

PARTS = parts_of(DOCS / "configs.md")
GIVEN = [part for part in PARTS if isinstance(part, File)]
TYPED = [part for part in PARTS if isinstance(part, Typed)]


@pytest.fixture(scope="module")
def folder(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("configs")
    (folder / "temporary").mkdir()
    copy_database(empty_database, folder / "outputs" / "mlflow.db")
    for path, text in GIVEN:
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    return folder


def test_the_page_contains_files_and_commands():
    assert len(GIVEN) == 5
    assert len(TYPED) == 15


@pytest.mark.parametrize("typed", TYPED, ids=lambda typed: " ".join(typed.words))
def test_a_command_works(typed: Typed, folder: Path):
    done = run(typed.words, folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout
    assert "cannot be used" not in done.stdout


@pytest.mark.parametrize("given", GIVEN, ids=lambda given: given.path)
def test_a_file_matches_its_schema(given: File):
    group = Path(given.path).parent.name
    schema = CONF / ("" if "@package _global_" in given.text else group) / "schema.json"
    problems = Draft7Validator(yaml.safe_load(schema.read_text(encoding="utf-8"))).iter_errors(
        yaml.safe_load(given.text)
    )
    assert [error.message for error in problems] == []


def test_interpolations_of_the_table_can_be_resolved():
    shown = re.findall(r"`(\$\{[^`]+\})`", (DOCS / "configs.md").read_text(encoding="utf-8"))
    assert len(shown) == 4
    config = OmegaConf.create({"world": {"size": 10}, "option": {"p": 3.0, **dict(zip("abcd", shown, strict=True))}})
    assert list(config.option.values()) == [3.0, 10, 3.0, 1000, "default"]


def test_the_studies_of_another_page_have_points(planner: Planner):
    shown = re.findall(r"```yaml\n(blocks:.*?)```", (DOCS / "sweeps.md").read_text(encoding="utf-8"), re.DOTALL)
    nodes = [yaml.safe_load(text) for text in shown]
    plans = [plan_study("shown", OmegaConf.create({"study": node}), (), planner) for node in nodes]
    # Four points, of which half are directions: each as three readings, three pairs and a triple change it.
    assert list(map(len, plans)) == [9, 4 + 2 * 3 + 2 * 7]
    dropped = [[dropped.constraint for dropped in plan.dropped] for plan in plans]
    assert dropped == [["goes_round"], ["variations"]]
