"""User modules run as their source says, even if a bytecode file says otherwise."""

from __future__ import annotations

import os
import py_compile
import sys
from collections.abc import Iterator
from importlib import import_module, invalidate_caches, reload
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import pytest

from rl_design_space.config.own_modules import import_from_source, source_of
from rl_design_space.errors import ConfigError
from rl_design_space.plan.code_identity import code_identity

SOURCE = "class Own:\n    level = 1\n"
CHANGED = SOURCE.replace("1", "2")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on Python's search path; the state of the process is restored afterwards."""
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path)])
    monkeypatch.setattr(sys, "path_hooks", [*sys.path_hooks])
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]
    for path in [path for path in sys.path_importer_cache if path.startswith(str(tmp_path))]:
        del sys.path_importer_cache[path]


def edit(path: Path, content: str) -> None:
    """Write a file as if it was edited within the second in which Python compiled it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(SOURCE, encoding="utf-8")
    os.utime(path, (1e9, 1e9))
    py_compile.compile(str(path), doraise=True)
    path.write_text(content, encoding="utf-8")
    os.utime(path, (1e9, 1e9))
    invalidate_caches()


def imported(name: str) -> ModuleType:
    return import_module(name)


@pytest.mark.parametrize("name", ["own_one", "own_package.inner.two"])
def test_what_is_imported_is_the_source(name: str, folder: Path):
    path = folder / f"{name.replace('.', '/')}.py"
    edit(path, CHANGED)
    assert imported(name).Own.level == 1  # the reason for all of this
    with pytest.raises(ConfigError, match=rf"{path}: was edited within a second, and Python has imported an earlier"):
        code_identity(imported(name).Own)
    del sys.modules[name]
    import_from_source([str(folder)])
    module = imported(name)
    assert module.Own.level == 2
    assert source_of(name, path) == CHANGED


def test_the_identity_is_that_of_the_import(folder: Path):
    import_from_source([str(folder)])
    path = folder / "own_three.py"
    path.write_text(SOURCE, encoding="utf-8")
    module = imported("own_three")
    path.write_text(CHANGED, encoding="utf-8")
    assert module.Own.level == 1
    before = code_identity(module.Own)
    assert source_of("own_three", path) == SOURCE
    assert code_identity(reload(module).Own) != before
    assert module.Own.level == 2


def test_modules_of_other_entries_of_the_path_are_left_to_python(folder: Path, monkeypatch: pytest.MonkeyPatch):
    packages = folder / "venv" / "site-packages"
    edit(packages / "own_four" / "__init__.py", SOURCE)
    edit(folder / "own_five.py", SOURCE)
    monkeypatch.syspath_prepend(packages)
    import_from_source([str(folder)])
    import_from_source([str(folder)])
    assert type(imported("own_four").__spec__.loader) is SourceFileLoader
    assert type(imported("own_five").__spec__.loader) is not SourceFileLoader
    assert len([hook for hook in sys.path_hooks if type(hook).__name__ == "_Hook"]) == 1


def test_this_package_is_left_to_python(folder: Path):
    checkout = Path(__file__).parents[2]
    import_from_source([str(checkout)])
    (hook,) = [hook for hook in sys.path_hooks if type(hook).__name__ == "_Hook"]
    with pytest.raises(ImportError):
        hook(str(checkout / "rl_design_space" / "report"))
