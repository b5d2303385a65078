"""import-linter accepts the package as it is, and rejects an upward import and a circle of imports."""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LINTER = Path(sysconfig.get_path("scripts")) / "lint-imports"

ONE_DIRECTION = "A room imports only the rooms below it"
NO_CIRCLE = "Modules do not import each other in a circle"


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Return a folder with a copy of the package and of the contracts."""
    shutil.copytree(
        ROOT / "rl_design_space", tmp_path / "rl_design_space", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def lint(folder: Path) -> tuple[int, str]:
    done = subprocess.run(
        [LINTER, "--no-logo", "--no-cache"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    return done.returncode, " ".join((done.stdout + done.stderr).split())


def append(file: Path, text: str) -> None:
    file.write_text(f"{file.read_text(encoding='utf-8')}\n{text}\n", encoding="utf-8")


def test_the_package_keeps_both_contracts(copy: Path):
    status, said = lint(copy)
    assert f"{ONE_DIRECTION} KEPT" in said
    assert f"{NO_CIRCLE} KEPT" in said
    assert status == 0


@pytest.mark.parametrize(
    "statement",
    [
        "import rl_design_space.report",
        "def late():\n    from rl_design_space import report",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from rl_design_space import report",
    ],
    ids=["plain", "in a function", "for a type"],
)
def test_an_upward_import_is_rejected(statement: str, copy: Path):
    append(copy / "rl_design_space" / "design" / "task.py", statement)
    status, said = lint(copy)
    assert status != 0
    assert f"{ONE_DIRECTION} BROKEN" in said
    assert "rl_design_space.design is not allowed to import rl_design_space.report" in said
    assert "rl_design_space.design.task -> rl_design_space.report" in said


def test_a_circle_within_a_room_is_rejected(copy: Path):
    append(copy / "rl_design_space" / "design" / "reward.py", "import rl_design_space.design.task")
    append(copy / "rl_design_space" / "design" / "task.py", "import rl_design_space.design.reward")
    status, said = lint(copy)
    assert status != 0
    assert f"{ONE_DIRECTION} KEPT" in said
    assert f"{NO_CIRCLE} BROKEN" in said
    assert "No cycles are allowed in rl_design_space.design." in said


def test_a_module_outside_of_every_room_is_rejected(copy: Path):
    (copy / "rl_design_space" / "attic.py").write_text("", encoding="utf-8")
    status, said = lint(copy)
    assert status != 0
    assert "attic" in said
