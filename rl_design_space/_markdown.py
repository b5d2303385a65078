"""Text in Markdown: what comes from a store or a command shows as it is, and is neither HTML nor a link."""

from __future__ import annotations

import re

#: A span of code: as many backticks at its end as at its beginning.
_CODE = re.compile(r"((?<!`)(`+)(?!`).*?(?<!`)\2(?!`))")
#: What means more than itself outside of code; stars stay, with which reports write bold text.
_ACTIVE = re.compile(r"[\\<]|(?<=\])(?=\()|(?<=!)(?=\[)")


def escaped(text: str) -> str:
    """Return text in one line that fits into a paragraph or a cell of a table; its code and bold text stay.

    HTML, links, pictures and bars are shown as they are written. Viewers differ in whether they run HTML.
    """
    # Backslashes of the text are escaped, so a backtick behind one begins code, for this function and for viewers.
    parts = _CODE.split(" ".join(text.split()))
    shown = [part if place % 3 else _ACTIVE.sub(r"\\\g<0>", part) for place, part in enumerate(parts) if place % 3 != 2]
    return "".join(shown).replace("|", r"\|")


def code(text: str) -> str:
    """Return text as a span of code in one line, whatever it holds."""
    line = " ".join(text.split())
    fence = "`" * (max(map(len, re.findall("`+", line)), default=0) + 1)
    space = " " if line[:1] == "`" or line[-1:] == "`" else ""
    return f"{fence}{space}{line}{space}{fence}"
