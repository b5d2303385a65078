"""The cache of compiled code: used again while the source is unchanged; learning works without it, too."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from rl_design_space.learning.compiled import CorruptedError, compile_timer, sealed, unsealed
from tests.command_runner import Completed, finished

PACKAGE = Path(__file__).parents[2] / "rl_design_space"

# A module for the copied package: it compiles in a tenth of the time of the package's own functions.
SMALL = """
from rl_design_space.learning.compiled import compiled_and_kept

@compiled_and_kept
def more(number):
    return number + 1
"""
# Prints the result, and the number of signatures that were compiled, not loaded.
PROGRAM = """
from rl_design_space.learning.small import more
print(more(1), sum(more.stats.cache_misses.values()))
"""
COMPILED, LOADED = "2 1", "2 0"
# The same for a function of the package that compiles in half a second: it numbers two of three observations.
NUMBERED = """
import numpy as np
from rl_design_space.learning.carrying import number_rows
rows = np.empty((1, 1, 3), dtype=np.int64)
number_rows(np.array([[[7, 5, 7]]]), rows)
print(rows.max() + 1, sum(number_rows.stats.cache_misses.values()))
"""

Run = Callable[..., Completed]


def copied(folder: Path) -> Path:
    """Copy the package into a folder, with the small function."""
    shutil.copytree(PACKAGE, folder / PACKAGE.name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / PACKAGE.name / "learning" / "small.py").write_text(SMALL, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package."""
    return copied(tmp_path_factory.mktemp("copy"))


@pytest.fixture
def edit(root: Path) -> Iterator[Callable[[str, str, str], None]]:
    """Replace text in a module of the copy until the end of the test."""
    before: dict[Path, str] = {}

    def replace(module: str, old: str, new: str) -> None:
        path = root / PACKAGE.name / "learning" / module
        before[path] = path.read_text(encoding="utf-8")
        assert old in before[path]
        path.write_text(before[path].replace(old, new), encoding="utf-8")

    yield replace
    for path, text in before.items():
        path.write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def first(root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Completed, Path]:
    """The first run of the program, and its cache."""
    cache = tmp_path_factory.mktemp("first")
    return _finished(_started(PROGRAM, root, cache)), cache


@pytest.fixture
def cache(first: tuple[Completed, Path], tmp_path: Path) -> Path:
    """A copy of the cache after the first run."""
    shutil.copytree(first[1], tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture
def run(root: Path, cache: Path) -> Run:
    """Run a program with the copied package and a compilation cache of its own."""
    return lambda program=PROGRAM, folder=cache, root=root: _finished(_started(program, root, folder))


def _started(program: str, root: Path, cache: Path) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(root), "NUMBA_CACHE_DIR": str(cache)}
    return subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def _finished(process: subprocess.Popen[str]) -> Completed:
    done = finished(process)
    assert done.returncode == 0, done.stderr
    return Completed(done.args, done.returncode, done.stdout.strip(), done.stderr)


def files_in(cache: Path) -> set[Path]:
    return {path for path in cache.rglob("*") if path.is_file()}


def test_another_process_loads_compiled_code(first: tuple[Completed, Path], run: Run, cache: Path):
    assert first[0].stdout == COMPILED
    files = files_in(cache)
    assert len(files) == 1
    again = run()
    assert (again.stdout, again.stderr, files_in(cache)) == (LOADED, "", files)


def test_a_function_of_the_package_is_cached(run: Run):
    assert [run(NUMBERED).stdout, run(NUMBERED).stdout] == [COMPILED, LOADED]


def test_code_compiled_from_other_source_is_not_used_and_is_removed(run: Run, cache: Path, edit):
    old = files_in(cache)
    edit("small.py", "number + 1", "number + 10")
    assert run().stdout == "11 1"
    assert len(files_in(cache)) == 1
    assert not files_in(cache) & old


def test_a_change_in_another_file_of_the_package_is_detected(run: Run, edit):
    edit("behaviour.py", "from __future__", "# Another version.\nfrom __future__")
    assert run().stdout == COMPILED


def test_a_missing_folder_is_created(run: Run, tmp_path: Path):
    folder = tmp_path / "not" / "yet"
    assert run(folder=folder).stdout == COMPILED
    assert len(files_in(folder)) == 1


@pytest.fixture
def nowhere(tmp_path: Path) -> Path:
    """A folder that cannot be created, even by the superuser, as whom containers often run."""
    (tmp_path / "file").write_text("")
    return tmp_path / "file" / "folder"


def test_a_folder_that_cannot_be_used_is_replaced_by_the_one_beside_the_source(run: Run, tmp_path: Path, nowhere: Path):
    root = copied(tmp_path / "other")
    assert run(folder=nowhere, root=root).stdout == COMPILED
    assert run(folder=nowhere, root=root).stdout == LOADED
    assert list((root / PACKAGE.name / "learning" / "__pycache__").glob("*.nbc"))


def test_without_any_folder_one_warning_is_given(
    run: Run, tmp_path: Path, nowhere: Path, monkeypatch: pytest.MonkeyPatch
):
    root = copied(tmp_path / "other")
    (root / PACKAGE.name / "learning" / "__pycache__").write_text("")
    monkeypatch.setenv("HOME", str(nowhere))
    monkeypatch.setenv("XDG_CACHE_HOME", str(nowhere))
    # With the cached functions of the package, the kernel and the optimum.
    finished = run("from rl_design_space.learning import kernel, optimum\n" + PROGRAM, nowhere, root)
    assert finished.stdout.startswith("2 ")
    assert finished.stderr.count("RuntimeWarning") == 1
    assert "NUMBA_CACHE_DIR" in finished.stderr


def test_a_corrupted_file_gives_a_warning_and_is_replaced(run: Run, cache: Path):
    (file,) = files_in(cache)
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1  # in the machine code, which may crash the process
    file.write_bytes(content)
    finished = run()
    assert finished.stdout == COMPILED
    assert f"RuntimeWarning: {file} is corrupted (checksum mismatch); its code is compiled again" in finished.stderr
    again = run()
    assert (again.stdout, again.stderr) == (LOADED, "")


@given(st.binary(max_size=64), st.data())
def test_any_damage_is_detected(code: bytes, data: st.DataObject):
    content = sealed("name", code)
    assert unsealed("name", content) == code
    flipped = bytearray(content)
    flipped[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    for damaged in (bytes(flipped), content[: data.draw(st.integers(0, len(content) - 1))], content + b"\0"):
        with pytest.raises(CorruptedError):
            unsealed("name", damaged)
    with pytest.raises(CorruptedError):
        unsealed("other", content)


def test_processes_that_compile_at_once_do_not_disturb_each_other(root: Path, tmp_path: Path):
    cache = tmp_path / "empty"
    processes = [_started(PROGRAM, root, cache) for _ in range(2)]
    for process in processes:
        finished = _finished(process)
        assert finished.stdout in (COMPILED, LOADED)
        assert finished.stderr == ""
    assert len(files_in(cache)) == 1


def test_the_time_of_compiling_is_measured_and_that_of_calls_is_not():
    twice = njit(lambda number: 2 * number)
    with compile_timer() as seconds:
        assert seconds() == 0
        assert twice(2) == 4
        compiled = seconds()
        assert compiled > 0
        assert twice(3) == 6
    assert seconds() == compiled
