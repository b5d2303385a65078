"""The Python blocks of the documentation run and print the output shown under them."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from markdown_it import MarkdownIt

from tests.tracking.stores import copy_database

ROOT = Path(__file__).parents[1]
PAGES = ("README.md", "docs/python.md")

#: Output that differs between runs.
_TIMES = re.compile(r"(?<=seconds {7})[\d.]+")


def blocks(page: str) -> list[tuple[str, str | None, int]]:
    """Return each Python block of a page, the text block that follows it (or None), and its first line."""
    fences = [token for token in MarkdownIt().parse((ROOT / page).read_text(encoding="utf-8")) if token.type == "fence"]
    following = [fence.content if fence.info == "text" else None for fence in fences[1:]] + [None]
    return [
        (fence.content, printed, fence.map[0] + 1)
        for fence, printed in zip(fences, following, strict=True)
        if fence.info == "python" and fence.map is not None
    ]


@pytest.mark.parametrize("page", PAGES)
def test_python_runs_and_prints_the_documented_output(
    page: str, tmp_path: Path, empty_database: Path, monkeypatch: pytest.MonkeyPatch
):
    copy_database(empty_database, tmp_path / "outputs" / "mlflow.db")
    monkeypatch.chdir(tmp_path)  # where what is recorded goes
    documented = blocks(page)
    assert documented
    names: dict[str, Any] = {"__name__": "documented"}
    for code, printed, line in documented:
        output = StringIO()
        # Blank lines before it, so that an error names the line of the page.
        program = compile("\n" * line + code, page, "exec", dont_inherit=True)
        with redirect_stdout(output):
            exec(program, names)
        assert _TIMES.sub("…", output.getvalue()) == _TIMES.sub("…", printed or ""), f"{page}, line {line}"
