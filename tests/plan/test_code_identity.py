"""The code of a user component is part of a point's identity: all code that may change results, and no other."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import make_dataclass
from importlib import import_module, invalidate_caches, reload
from pathlib import Path

import pytest

from rl_design_space.design import AdHoc, DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.plan import code_identity as module
from rl_design_space.plan.code_identity import code_identity
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.plan.source_files import code, modules_beside
from tests.command_runner import python

MODULE = '''"""A schedule."""
from dataclasses import dataclass
import numpy as np
from helpers.levels import LEVEL  # of all trials

@dataclass(frozen=True)
class Level:
    factor: float = 1.0

    def schedule(self, trials):
        import more_helpers
        return np.full(trials, LEVEL * self.factor)
'''
FILES = {
    "own_level.py": MODULE,
    "helpers/levels.py": "from .base import BASE\nLEVEL = BASE / 2\n",
    "helpers/base.py": "BASE = 0.2\n",
    "more_helpers.py": "MORE = 1\n",
    "unrelated.py": "OTHER = 1\n",
}

Of = Callable[..., str]


@pytest.fixture
def of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Of]:
    """Write files, import the class, and return its code identity."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def kind_of(**changed: str) -> str:
        for name, content in FILES.items():
            path = tmp_path / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(changed.get(path.stem, content), encoding="utf-8")
        forget(tmp_path)
        invalidate_caches()
        return code_identity(import_module("own_level").Level)

    yield kind_of
    forget(tmp_path)


def forget(folder: Path) -> None:
    for name, loaded in list(sys.modules.items()):
        if str(getattr(loaded, "__file__", None) or "").startswith(str(folder)) or name == "helpers":
            del sys.modules[name]


@pytest.mark.parametrize(
    "changed",
    [
        {"own_level": MODULE.replace("factor: float = 1.0", "factor: float = 0.5")},
        {"own_level": MODULE.replace("np.full(trials,", "np.full(trials, 1.0 *")},
        {"levels": "from .base import BASE\nLEVEL = BASE / 4\n"},
        {"base": "BASE = 0.4\n"},
        {"more_helpers": "MORE = 2\n"},
        {"own_level": MODULE.replace('"""A schedule."""', '"""A schedule.  # not a comment\n\n"""')},
    ],
    ids=["default", "method", "helper", "helper of a helper", "import in a function", "text"],
)
def test_code_that_may_change_results_changes_the_identity(changed: dict[str, str], of: Of):
    assert of(**changed) != of()


@pytest.mark.parametrize(
    "changed",
    [
        {"own_level": MODULE.replace("# of all trials", "# others")},
        {"own_level": "# By me.\n\n\n" + MODULE.replace("        import", "\n        # now\n\n        import")},
        {"levels": "# Levels.\n" + FILES["helpers/levels.py"]},
        {"unrelated": "OTHER = 2\n"},
    ],
    ids=["comment", "comments and blank lines", "comment of a helper", "a file that is not imported"],
)
def test_code_that_cannot_change_results_keeps_the_identity(changed: dict[str, str], of: Of):
    assert of(**changed) == of()


def test_a_version_replaces_the_source(of: Of):
    versioned = MODULE.replace("    factor", '    __version__ = "2"\n    factor', 1)
    assert of(own_level=versioned) == "version 2"
    assert of(own_level=versioned, base="BASE = 0.4\n") == "version 2"
    assert of(own_level=versioned.replace('"2"', "3")) == "version 3"


@pytest.mark.parametrize("version", ["True", "1.5", "()"])
def test_a_version_is_a_string_or_a_whole_number(version: str, of: Of):
    with pytest.raises(ConfigError, match=r"own_level\.Level\.__version__=.*should be a string or a whole number"):
        of(own_level=MODULE.replace("    factor", f"    __version__ = {version}\n    factor", 1))


def test_an_inherited_version_is_ignored(of: Of):
    of(own_level=MODULE + "\nclass Base(Level):\n    __version__ = 1\n\nclass Derived(Base):\n    pass\n")
    module = sys.modules["own_level"]
    assert code_identity(module.Base) == "version 1"
    assert code_identity(module.Derived).startswith("sha256:")


def test_the_imported_source_counts_not_the_file_on_disk(of: Of, tmp_path: Path):
    before = of()
    module = sys.modules["own_level"]
    (tmp_path / "own_level.py").write_text(MODULE.replace("1.0", "0.5"), encoding="utf-8")
    assert code_identity(module.Level) == before
    assert code_identity(reload(module).Level) != before


def test_a_class_without_a_file_needs_a_version():
    kind = make_dataclass("Unwritten", [], bases=(AdHoc,), frozen=True, namespace={"__module__": "nowhere"})
    with pytest.raises(ConfigError, match=r"nowhere\.Unwritten: has no source file .* declare __version__"):
        fingerprint(DesignPoint(representation=kind()))


def test_only_user_components_have_a_source_parameter(of: Of):
    found = of()
    own = DesignPoint(exploration=sys.modules["own_level"].Level())
    parameters = PlannedPoint.of(own, {}).parameters
    assert parameters["exploration.source"] == found[: len("sha256:") + 12]
    assert [name for name in parameters if name.endswith(".source")] == ["exploration.source"]
    assert not any(name.endswith(".source") for name in PlannedPoint.of(DesignPoint(), {}).parameters)


def test_the_source_is_part_of_the_fingerprint(of: Of):
    def found() -> str:
        return fingerprint(DesignPoint(exploration=sys.modules["own_level"].Level()))

    of()
    before = found()
    of(base="BASE = 0.4\n")
    assert found() != before


def test_the_identity_is_the_same_in_another_process(of: Of, tmp_path: Path):
    here = of()
    program = (
        "from rl_design_space.plan.code_identity import code_identity; import own_level; "
        "print(code_identity(own_level.Level))"
    )
    there = python(program, env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert there.strip() == here


def test_only_modules_of_the_same_installed_package_count(tmp_path: Path):
    packages = tmp_path / "site-packages"
    for name, content in {
        "parts/__init__.py": "",
        "parts/walls.py": "import other\nfrom parts import doors\nfrom .. import beyond\n",
        "parts/doors.py": "import broken_syntax\n",
        "other.py": "",
    }.items():
        (packages / name).parent.mkdir(parents=True, exist_ok=True)
        (packages / name).write_text(content, encoding="utf-8")
    found = modules_beside("parts.walls", packages / "parts" / "walls.py")
    assert set(found) == {"parts", "parts.walls", "parts.doors"}


def test_modules_of_this_package_are_ignored_in_a_checkout():
    here = Path(__file__).parents[2]
    assert not [name for name in modules_beside("tests.misfits", here / "tests" / "misfits.py") if "rl_design" in name]
    assert not [name for name in modules_beside(__name__, Path(__file__)) if name.startswith("rl_design_space")]


def test_a_file_that_is_not_python_counts_unchanged(tmp_path: Path):
    file = tmp_path / "broken.py"
    file.write_text("x = (  # open\n", encoding="utf-8")
    assert code(file.read_text(encoding="utf-8")) == "x = (  # open\n"
    assert modules_beside("broken", file) == {"broken": file}


def test_a_source_is_digested_once(of: Of, monkeypatch: pytest.MonkeyPatch):
    of()
    monkeypatch.setattr(module, "modules_beside", None)
    assert code_identity(sys.modules["own_level"].Level).startswith("sha256:")
