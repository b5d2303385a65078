"""Every wait of the tests and benchmarks has a limit, so that a fault fails a test instead of stopping all of them."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted([*ROOT.glob("tests/**/*.py"), *ROOT.glob("benchmarks/**/*.py")])
#: Functions of `subprocess` that wait, and methods that wait for ever without an argument.
PROCESSES = {"run", "call", "check_call", "check_output"}
METHODS = {"wait", "communicate", "join", "result", "get", "acquire"}


def unlimited_waits(source: str) -> list[int]:
    """Return the lines of calls that wait without a limit."""
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    return [call.lineno for call in calls if isinstance(call.func, ast.Attribute) and _has_no_limit(call, call.func)]


def _has_no_limit(call: ast.Call, function: ast.Attribute) -> bool:
    if any(keyword.arg in ("timeout", "patience", None) for keyword in call.keywords):
        return False
    if isinstance(function.value, ast.Name) and function.value.id == "subprocess":
        return function.attr in PROCESSES
    return function.attr in METHODS and not call.args


def test_every_wait_has_a_limit():
    assert Path(__file__) in FILES
    found = {path: unlimited_waits(path.read_text(encoding="utf-8")) for path in FILES}
    assert [f"{path.relative_to(ROOT)}:{line}" for path, lines in found.items() for line in lines] == []


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        ("process.wait()", [1]),
        ("a = 1\nprocess.communicate()", [2]),
        ("queue.get()", [1]),
        ("subprocess.run(command, check=True)", [1]),
        ("subprocess.run(command, timeout=9)", []),
        ("process.wait(9)", []),
        ("queue.get(timeout=9)", []),
        ("', '.join(words)", []),
        ("subprocess.Popen(command)", []),
    ],
)
def test_a_wait_without_a_limit_is_found(source: str, lines: list[int]):
    assert unlimited_waits(source) == lines
