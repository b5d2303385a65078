"""Markdown tables: cells, alignment and odd headers."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt
from markdown_it.token import Token

from rl_design_space._markdown import code, escaped
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


#: What a viewer shows of a text that is not HTML, a link or a picture.
HARMLESS = {"text", "code_inline", "strong_open", "strong_close", "em_open", "em_close", "text_special"}


def shown(markdown: str) -> Iterator[Token]:
    """Yield the parts of the lines of a text as a viewer that runs HTML reads them."""
    for token in MarkdownIt("commonmark", {"html": True}).enable("table").parse(markdown):
        assert token.type != "html_block"
        yield from token.children or ()


@pytest.mark.parametrize(
    "text",
    [
        "<script>alert(1)</script>",
        r"\<b>",
        r"\\<b>",
        "<https://host>",
        "[me](javascript:x)",
        "![me](http://host/x.png)",
        "a`<b>",
        r"\`<b>`",
        "``<b>`",
        "`<b>``",
        "<b>`c`<i>",
        "`|<b>|`",
        "& &lt;b&gt; &#60;b>",
    ],
)
def test_a_value_is_shown_as_it_is_and_is_no_html_in_any_viewer(text: str):
    found = list(shown(table(pd.DataFrame({"a": [text], text: ["x"]}))))
    assert {token.type for token in found} <= HARMLESS
    if "&" not in text:
        seen = "".join(token.content for token in found)
        assert seen.replace("`", "") == f"a{text}{text}x".replace("`", "")


@given(
    st.lists(st.sampled_from([*"<>[]()!`|\\*_&;:#\n a", "http://x", "``", "script", "](", "<b>"]), max_size=12).map(
        "".join
    )
)
@settings(max_examples=150)
def test_no_text_is_html_a_link_or_a_picture(text: str):
    assert {token.type for token in shown(table(pd.DataFrame({"a": [text], "b": ["x"]})))} <= HARMLESS
    assert {token.type for token in shown(f"With {escaped(text)}.")} <= HARMLESS
    spans = [token for token in shown(f"Made by {code('a' + text)}.") if token.type == "code_inline"]
    assert [span.content for span in spans] == [" ".join(f"a{text}".split())]
