"""The Python of the documentation runs, and prints what stands under it."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[1]
PAGES = ("README.md", "docs/python.md")

#: What differs from one run to the next.
_TIMES = re.compile(r"(?<=seconds {7})[\d.]+")


def blocks(page: str) -> list[tuple[str, str | None, int]]:
    """Every Python block of a page, the text block that follows it if there is one, and its first line."""
    fences = [token for token in MarkdownIt().parse((ROOT / page).read_text(encoding="utf-8")) if token.type == "fence"]
    following = [fence.content if fence.info == "text" else None for fence in fences[1:]] + [None]
    return [
        (fence.content, printed, fence.map[0] + 1)
        for fence, printed in zip(fences, following, strict=True)
        if fence.info == "python" and fence.map is not None
    ]


@pytest.mark.parametrize("page", PAGES)
def test_python_runs_and_prints_what_is_written(page: str):
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
