"""Markdown tables: cells, alignment and odd headers."""

from __future__ import annotations

import pandas as pd
from markdown_it import MarkdownIt

from rl_design_space.report.markdown import table


def cells(markdown: str) -> list[str]:
    """Return the cells of a table as a Markdown parser reads them."""
    tokens = MarkdownIt("commonmark").enable("table").parse(markdown)
    return [token.content for token in tokens if token.type == "inline"]


def test_bars_and_line_breaks_do_not_end_a_cell():
    assert cells(table(pd.DataFrame({"a|b": ["x | y", "`p|q`"], "": ["two\nlines", "z"]}))) == [
        "a|b", "", "x | y", "two lines", "`p|q`", "z",
    ]  # fmt: skip


def test_columns_of_numbers_are_aligned_on_the_right():
    frame = pd.DataFrame({"n": [1, 20], "share": ["5.0%", ""], "text": ["1 – 2", "3"], "none": ["", ""]})
    line = table(frame).splitlines()[1].strip("|")
    assert ["right" if cell.endswith(":") else "left" for cell in line.split("|")] == ["right", "right", "left", "left"]


def test_columns_of_one_name_and_no_rows_are_allowed():
    header = ["a", "(95 %)", "(95 %)"]
    assert cells(table(pd.DataFrame([["1", "2", "3"]], columns=header))) == [*header, "1", "2", "3"]
    assert cells(table(pd.DataFrame(columns=header))) == header
