"""What a docstring in Google's style says of a class and of its fields."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from typing import NamedTuple

_SECTION = re.compile(r"^(Args|Attributes|Examples?|Notes?|Raises|References|Returns|See Also|Yields):$", re.MULTILINE)
_ENTRY = re.compile(r"^ {4}(\w+(?:, \w+)*)(?: \([^)]*\))?:(.*(?:\n(?: {5,}.*|(?=\n)))*)", re.MULTILINE)


class Docstring(NamedTuple):
    """A docstring in its parts.

    Attributes:
        summary: its first sentence or line, without the full stop.
        text: all that stands before its sections.
        fields: what it says of each field, those of base classes included.
    """

    summary: str
    text: str
    fields: Mapping[str, str]


def docstring_of(kind: type) -> Docstring:
    """What is said of a class; empty where nothing is."""
    fields: dict[str, str] = {}
    for base in reversed(kind.__mro__[:-1]):
        fields |= _fields(_own(base))
    text = _SECTION.split(_own(kind), maxsplit=1)[0].strip()
    return Docstring(text.partition("\n")[0].rstrip("."), text, fields)


def _own(kind: type) -> str:
    """The class's own docstring, which is not what the standard library writes into a dataclass that has none."""
    written = kind.__dict__.get("__doc__") or ""
    return "" if written.startswith(f"{kind.__name__}(") else inspect.cleandoc(written)


def _fields(text: str) -> dict[str, str]:
    _, *sections = _SECTION.split(text)
    named = zip(sections[::2], sections[1::2], strict=True)
    entries = [_ENTRY.findall(section) for name, section in named if name in ("Args", "Attributes")]
    return {name: " ".join(said.split()) for found in entries for names, said in found for name in names.split(", ")}
