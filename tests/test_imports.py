"""Learning imports neither configuration, tracking nor plots; designs import no compiler."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest
import yaml

import rl_design_space
from rl_design_space._paths import CONF
from tests.command_runner import python

ROOT = Path(__file__).parents[1]

HEAVY = {"gymnasium", "hydra", "omegaconf", "mlflow", "pandas", "seaborn", "matplotlib"}


def imported_by(statements: str) -> set[str]:
    """Return the top-level modules that a new interpreter has imported after these statements."""
    program = f"import sys\n{statements}\nprint(*{{name.partition('.')[0] for name in sys.modules}})"
    return set(python(program, cwd=ROOT).split())


@pytest.mark.parametrize("package", ["rl_design_space.design", "rl_design_space.learning"])
def test_design_and_learning_import_nothing_heavy(package: str):
    assert not imported_by(f"import {package}") & HEAVY


def test_a_design_needs_no_compiler():
    assert "numba" not in imported_by("import rl_design_space.design")


def test_learning_needs_only_the_compiler():
    point = "DesignPoint(task=Task(periods=1, trials=1))"
    statements = (
        "from rl_design_space.design import DesignPoint, Task\n"
        "from rl_design_space.learning import simulate\n"
        f"simulate({point}, threads=1)"
    )
    modules = imported_by(statements)
    assert "numba" in modules
    assert not modules & HEAVY


def test_the_package_alone_imports_no_numerical_library():
    assert not imported_by("import rl_design_space") & {*HEAVY, "numpy", "pydantic", "numba"}


def test_a_report_imports_neither_the_compiler_nor_what_draws_other_reports():
    names = "QualityMap, ClaimsLedger, PublishedTable"
    modules = imported_by(f"import rl_design_space.plan.study\nfrom rl_design_space.report import {names}")
    assert "matplotlib" in modules
    assert not modules & {"numba", "seaborn", "mlflow", "jinja2"}


def test_every_public_name_exists_and_is_offered():
    assert set(rl_design_space.__all__) <= set(dir(rl_design_space))
    found = {name: getattr(rl_design_space, name) for name in rl_design_space.__all__}
    assert found.pop("__version__").count(".") == 2
    assert {name: component.__name__ for name, component in found.items()} == {name: name for name in found}
    with pytest.raises(AttributeError, match="no attribute 'Directions'"):
        rl_design_space.Directions  # noqa: B018


def test_every_option_is_public():
    """Every option that can be chosen in YAML can be built in Python."""
    targets = {yaml.safe_load(file.read_text(encoding="utf-8")).get("_target_") for file in CONF.glob("*/*.yaml")}
    options = {
        target.rpartition(".")[2] for target in targets if target and target.startswith("rl_design_space.design.")
    }
    assert len(options) > 10
    assert options <= set(rl_design_space.__all__)


def test_every_package_says_what_is_public():
    """What is outside `__all__` is internal and may change."""
    packages = [path.parent for path in Path(rl_design_space.__file__).parent.rglob("__init__.py")]
    names = [".".join(path.relative_to(Path(rl_design_space.__file__).parents[1]).parts) for path in packages]
    found = {name: import_module(name) for name in names if "_plugins" not in name}
    assert len(found) > 10
    assert [name for name, package in found.items() if not hasattr(package, "__all__")] == []
