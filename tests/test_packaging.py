"""The wheel carries all it needs and runs from anywhere; what is declared and locked can be relied on."""

from __future__ import annotations

import os
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from rl_design_space._paths import CONF
from tests.command_runner import output_of

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DEPENDENCIES = [Requirement(line) for line in PROJECT["dependencies"]]
LOCKS = sorted(ROOT.glob("requirements*.txt"))


def pip(*arguments: object) -> None:
    output_of(sys.executable, "-m", "pip", "--disable-pip-version-check", *arguments)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    # Nothing is downloaded: the build backend is among the test requirements.
    pip("wheel", "--no-deps", "--no-index", "--no-build-isolation", "--wheel-dir", folder, ROOT)
    (built,) = folder.iterdir()
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("installed")
    pip("install", "--no-deps", "--no-index", "--target", folder, wheel)
    return folder


@pytest.fixture
def python(installed: Path, tmp_path: Path):
    """Run Python in another folder, with the installed wheel before any other copy of the package."""

    def run(*arguments: str) -> str:
        variables = {**os.environ, "PYTHONPATH": str(installed)}
        return output_of(sys.executable, "-P", *arguments, cwd=tmp_path, env=variables)

    return run


def names(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_the_wheel_holds_every_config_file(wheel: Path):
    files = [file for file in CONF.rglob("*") if file.is_file()]
    expected = {f"rl_design_space/conf/{file.relative_to(CONF).as_posix()}" for file in files}
    assert {name for name in names(wheel) if name.startswith("rl_design_space/conf/")} == expected
    assert {"rl_design_space/conf/config.yaml", "rl_design_space/conf/world/schema.json"} <= expected


def test_the_wheel_holds_every_module_and_nothing_else(wheel: Path):
    package = ROOT / "rl_design_space"
    expected = {f"rl_design_space/{file.relative_to(package).as_posix()}" for file in package.rglob("*.py")}
    found = names(wheel)
    assert {name for name in found if name.endswith(".py")} == expected
    assert {name.partition("/")[0] for name in found} == {
        "rl_design_space",
        f"rl_design_space-{wheel.name.split('-')[1]}.dist-info",
    }
    assert any(name.endswith("licenses/LICENSE") for name in found)
    templates = {f"rl_design_space/{file.relative_to(package).as_posix()}" for file in package.rglob("*.jinja")}
    assert {name for name in found if name.endswith(".jinja")} == templates
    assert {
        "rl_design_space/report/templates/page.html.jinja",
        "rl_design_space/commands/templates/world.py.jinja",
    } <= found


def test_the_wheel_brings_its_plugins(python):
    shown = python("-m", "rl_design_space", "--info", "plugins")
    assert "DesignSweeper" in shown
    assert "DesignLauncher" in shown


def test_the_wheel_runs_from_another_folder(python, installed: Path, tmp_path: Path):
    places = python(
        "-c", "import rl_design_space as r; from rl_design_space._paths import CONF; print(r.__file__, CONF)"
    )
    # Not the checkout, which is installed as well.
    assert places.split() == [
        str(installed / "rl_design_space" / "__init__.py"),
        str(installed / "rl_design_space" / "conf"),
    ]
    shown = python("-m", "rl_design_space", "tracking=none", "task.periods=2")
    assert "total steps a period" in shown
    assert list(tmp_path.rglob("*.db")) == []


def test_both_commands_come_with_the_wheel(installed: Path):
    assert {path.name for path in (installed / "bin").iterdir()} == {"rl-design-space", "rl-design-report"}


@pytest.mark.parametrize("requirement", DEPENDENCIES, ids=str)
def test_every_dependency_is_bounded_on_both_sides(requirement: Requirement):
    operators = {bound.operator for bound in requirement.specifier}
    assert operators == {">=", "<"}


@pytest.mark.parametrize("name", ["hydra-core", "mlflow", "omegaconf"])
def test_what_breaks_between_minor_versions_is_held_to_one(name: str):
    (found,) = [requirement for requirement in DEPENDENCIES if requirement.name == name]
    (lowest,) = [bound.version for bound in found.specifier if bound.operator == ">="]
    major, minor = map(int, lowest.split(".")[:2])
    assert not found.specifier.contains(f"{major}.{minor + 1}.0")


@pytest.mark.parametrize("lock", LOCKS, ids=lambda path: path.name)
def test_a_lock_file_names_no_index(lock: Path):
    assert [line for line in lock.read_text(encoding="utf-8").splitlines() if "://" in line] == []


@pytest.mark.parametrize("lock", LOCKS, ids=lambda path: path.name)
def test_a_lock_file_holds_one_version_and_hashes_of_everything(lock: Path):
    joined = lock.read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line for line in joined.splitlines() if line and not line.lstrip().startswith("#")]
    assert lines
    for line in lines:
        requirement, *hashes = line.split("--hash=sha256:")
        assert [bound.operator for bound in Requirement(requirement.strip()).specifier] == ["=="]
        assert hashes


def test_the_lock_files_hold_every_dependency():
    def locked(name: str) -> dict[str, str]:
        lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
        pinned = [line.rstrip(" \\") for line in lines if "==" in line and not line.lstrip().startswith("#")]
        return {Requirement(pin).name: str(Requirement(pin).specifier) for pin in pinned}

    run, test = locked("requirements.txt"), locked("requirements-test.txt")
    assert {requirement.name for requirement in DEPENDENCIES} <= set(run)
    extras = {Requirement(line).name.lower() for line in PROJECT["optional-dependencies"]["test"]}
    assert extras <= {name.lower() for name in test}
    # Testing changes no version of what runs.
    assert {name: test[name] for name in run} == run
