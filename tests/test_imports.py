"""What learns needs neither configuration, nor tracking, nor plots; what describes a design needs no compiler."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

HEAVY = {"gymnasium", "hydra", "omegaconf", "mlflow", "pandas", "seaborn", "matplotlib"}


def imported_by(statements: str) -> set[str]:
    """Top-level modules that a fresh interpreter holds after these statements."""
    program = f"import sys\n{statements}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    output = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    return set(output.split())


@pytest.mark.parametrize("package", ["rl_design_space.design", "rl_design_space.learning"])
def test_imports_nothing_heavy(package: str):
    assert not imported_by(f"import {package}") & HEAVY


def test_a_design_needs_no_compiler():
    assert "numba" not in imported_by("import rl_design_space.design")


def test_learning_needs_nothing_but_the_compiler():
    point = "DesignPoint(task=Task(periods=1, trials=1))"
    statements = (
        "from rl_design_space.design import DesignPoint, Task\n"
        "from rl_design_space.learning import simulate\n"
        f"simulate({point}, threads=1)"
    )
    modules = imported_by(statements)
    assert "numba" in modules
    assert not modules & HEAVY
