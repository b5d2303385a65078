"""Text from a store, a file or the command line, as it may be shown: control characters are written out."""

from __future__ import annotations

import re

#: Control characters except tabs and newlines, which reach a terminal as commands, and are not allowed in an SVG; and
#: characters that reverse the direction of the text around them.
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def visible(text: str) -> str:
    r"""Return text with `\x1b` and the like in place of control characters."""
    return _CONTROL.sub(lambda found: repr(found[0])[1:-1], text)
