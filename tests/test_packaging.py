"""The wheel carries all it needs and runs from anywhere; what is declared and locked can be relied on."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from rl_design_space._paths import CONF
from tests.command_runner import PATIENCE, output_of

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
DEPENDENCIES = [Requirement(line) for line in PROJECT["dependencies"]]
#: Requirements of each extra; those in DEVELOPMENT are installed from lock files.
EXTRAS = {name: list(map(Requirement, lines)) for name, lines in PROJECT["optional-dependencies"].items()}
DEVELOPMENT = {"test", "bench"}
#: Extras that take gigabytes, and are not installed for tests.
LARGE = {"sb3"}
FOR_USERS = [requirement for name in EXTRAS.keys() - DEVELOPMENT - LARGE for requirement in EXTRAS[name]]
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
    # Code that was compiled from the same source is used, wherever it was compiled; compiling takes seconds.
    for compiled in ROOT.glob("rl_design_space/*/__pycache__/*.nbc"):
        target = folder / compiled.relative_to(ROOT)
        target.parent.mkdir(exist_ok=True)
        shutil.copy(compiled, target)
    return folder


@pytest.fixture
def python(installed: Path, tmp_path: Path):
    """Run Python in another folder, with the installed wheel before any other copy of the package."""

    def run(*arguments: str) -> str:
        variables = {**os.environ, "PYTHONPATH": str(installed)}
        return output_of(sys.executable, "-P", *arguments, cwd=tmp_path, env=variables)

    return run


@pytest.fixture(scope="module")
def typed(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], list[str]]:
    """Check a script with mypy in an environment that has the wheel, NumPy and pydantic; return the lines it prints."""
    folder = tmp_path_factory.mktemp("typed")
    output_of(sys.executable, "-m", "venv", "--without-pip", folder / "venv")
    python = folder / "venv" / "bin" / "python"
    packages = Path(output_of(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    (packages / "rl_design_space").symlink_to(installed / "rl_design_space")
    for name in ("numpy", "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection"):
        origin = Path(find_spec(name).origin)
        found = origin.parent if origin.name.startswith("__init__.") else origin
        (packages / found.name).symlink_to(found)
    # An empty name: neither the configuration of this repository nor that of the user.
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--python-executable", str(python)]

    def check(script: str) -> list[str]:
        (folder / "script.py").write_text(script, encoding="utf-8")
        done = subprocess.run([*command, "script.py"], cwd=folder, capture_output=True, text=True, timeout=PATIENCE)
        assert done.returncode in (0, 1), done.stdout + done.stderr
        return done.stdout.splitlines()

    return check


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
        "rl_design_space/commands/words/templates/world.py.jinja",
    } <= found


def test_wheel_and_source_archive_say_that_the_package_is_typed(wheel: Path, tmp_path: Path):
    assert "rl_design_space/py.typed" in names(wheel)
    output_of(sys.executable, "-m", "hatchling", "build", "--target", "sdist", "--directory", tmp_path, cwd=ROOT)
    (archive,) = tmp_path.iterdir()
    with tarfile.open(archive) as opened:
        assert f"{archive.name.removesuffix('.tar.gz')}/rl_design_space/py.typed" in opened.getnames()
    assert "Typing :: Typed" in PROJECT["classifiers"]


SCRIPT = """\
import rl_design_space as rds
point = rds.DesignPoint(representation=rds.Direction(), exploration=rds.Linear(k=0.02), task=rds.Task(periods=2))
same = rds.DesignPoint.from_overrides(["representation=direction", "exploration=linear", "task.periods=2"])
curves = rds.simulate(point)
print(curves.steps.shape, curves.steps.mean(axis=0)[0] + 1.5, same.world.shape)
"""
#: Lines with a mistake, and the code of the error that mypy should find in them.
MISTAKES = {
    'rds.Linear(k="x")': "arg-type",
    "rds.Lineer()": "attr-defined",
    "rds.DesignPoint(representation=rds.Linear())": "arg-type",
    "rds.DesignPoint(colour=3)": "call-arg",
    "rds.simulate(3)": "arg-type",
    "curves.stepps": "attr-defined",
    "point.seed = 4": "misc",
    'curves.steps + "x"': "operator",
}


def test_a_script_that_uses_the_wheel_passes_strict_type_checks(typed: Callable[[str], list[str]]):
    assert typed(SCRIPT) == ["Success: no issues found in 1 source file"]


def test_mistakes_in_a_script_are_type_errors(typed: Callable[[str], list[str]]):
    *errors, _ = typed(SCRIPT + "\n".join(MISTAKES))
    first = len(SCRIPT.splitlines()) + 1
    found = {int(line.split(":")[1]): line.rpartition("[")[2].rstrip("]") for line in errors if ": error: " in line}
    assert found == {first + number: code for number, code in enumerate(MISTAKES.values())}


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


@pytest.mark.parametrize("requirement", sorted([*DEPENDENCIES, *FOR_USERS], key=str), ids=str)
def test_every_dependency_is_bounded_on_both_sides(requirement: Requirement):
    operators = {bound.operator for bound in requirement.specifier}
    assert operators == {">=", "<"}


@pytest.mark.parametrize("name", ["hydra-core", "mlflow", "omegaconf"])
def test_what_breaks_between_minor_versions_is_held_to_one(name: str):
    (found,) = [requirement for requirement in DEPENDENCIES if requirement.name == name]
    (lowest,) = [bound.version for bound in found.specifier if bound.operator == ">="]
    major, minor = map(int, lowest.split(".")[:2])
    assert not found.specifier.contains(f"{major}.{minor + 1}.0")


def test_no_bound_lets_pip_install_a_prerelease():
    everything = [*DEPENDENCIES, *(requirement for extra in EXTRAS.values() for requirement in extra)]
    assert [str(requirement) for requirement in everything if requirement.specifier.prereleases] == []


@pytest.mark.parametrize("name", [found.name for found in EXTRAS["test"] if found.name.startswith("hydra-")])
def test_a_plugin_of_hydra_is_held_to_the_minor_version_of_hydra(name: str):
    (found,) = [requirement for requirement in EXTRAS["test"] if requirement.name == name]
    assert found.specifier.contains("1.3.0")
    assert not found.specifier.contains("1.4.0")


def test_tests_use_the_versions_that_users_get():
    tested = {requirement.name: requirement.specifier for requirement in EXTRAS["test"]}
    assert {name for name in (found.name for found in FOR_USERS) if name not in tested} == {"sqlalchemy"}
    assert all(tested[found.name] == found.specifier for found in FOR_USERS if found.name in tested)


def test_the_script_that_installs_every_extra_knows_all_of_them():
    script = (ROOT / ".ci" / "extras").read_text(encoding="utf-8")
    assert f"all=({' '.join(name for name in EXTRAS if name not in DEVELOPMENT | LARGE)})" in script
    done = subprocess.run([ROOT / ".ci" / "extras", "nothing"], capture_output=True, text=True, timeout=PATIENCE)
    told = "error: nothing: no such extra (there is dask ray optuna gym explore postgres server)\n"
    assert (done.returncode, done.stderr) == (2, told)


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
