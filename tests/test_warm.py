"""A command in a process that has made its imports behaves as in a new one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_runner import Completed
from tests.order import LONGEST, TOGETHER
from tests.warm import warm

ENDINGS = {
    "nothing": "",
    "status": "raise SystemExit(3)",
    "text": "raise SystemExit('why')",
    "error": "1 / 0",
    "thread": "import threading, time; threading.Thread(target=lambda: (time.sleep(0.1), print('late'))).start()",
    "handler": "import atexit; atexit.register(print, 'at exit')",
}
REPORT = """
import os, sys, tempfile
import beside, elsewhere
print(sys.argv, os.getcwd(), dict(os.environ), tempfile.gettempdir(), __name__, sys.stdin.read())
print("problems", file=sys.stderr)
"""


@pytest.fixture
def both(tmp_path: Path):
    """Run a script in both ways."""
    for name in ("scripts/beside.py", "own/elsewhere.py", "folder/file"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).touch()
    script = tmp_path / "scripts" / "script"
    env = {"PYTHONPATH": str(tmp_path / "own"), "TMPDIR": str(tmp_path), "LANG": "C.UTF-8"}

    def run(text: str) -> tuple[Completed, Completed]:
        script.write_text(text, encoding="utf-8")
        words, options = [str(script), "a", "b c"], {"cwd": tmp_path / "folder", "env": env, "timeout": 60}
        cold = subprocess.run(
            [sys.executable, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL, **options
        )
        return warm().run(words, **options), cold

    return run


def test_a_command_gets_its_arguments_and_variables_and_folders(both):
    got, expected = both(REPORT)
    assert (got.returncode, got.stdout, got.stderr) == (0, expected.stdout, "problems\n")
    assert "'b c'" in got.stdout


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_command_ends_in_its_own_way(both, ending: str):
    got, expected = both(ENDINGS[ending])
    assert (got.returncode, got.stdout) == (expected.returncode, expected.stdout)
    assert got.stderr.splitlines()[-1:] == expected.stderr.splitlines()[-1:]


def test_a_command_that_takes_too_long_is_killed(tmp_path: Path):
    script = tmp_path / "script"
    script.write_text("import time; time.sleep(60)", encoding="utf-8")
    with pytest.raises(subprocess.TimeoutExpired):
        warm().run([str(script)], cwd=tmp_path, env={}, timeout=0.2)
    script.write_text("print('next')", encoding="utf-8")
    assert warm().run([str(script)], cwd=tmp_path, env={}, timeout=60).stdout == "next\n"


def test_the_files_that_are_put_in_an_order_exist():
    tests = Path(__file__).parent
    files = [*(tests / name for name in LONGEST), *(tests.parent / name for pair in TOGETHER.items() for name in pair)]
    assert [file for file in files if not file.exists()] == []
