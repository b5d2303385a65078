"""The commands of docs/configs.md work as written, and its files match their schemas."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from jsonschema import Draft7Validator

from rl_design_space._paths import CONF
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
    assert len(GIVEN) == 4
    assert len(TYPED) == 14


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
