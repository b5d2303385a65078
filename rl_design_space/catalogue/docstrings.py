"""Descriptions of a class and of its fields, from its docstring in Google's style.

Pydantic reads docstrings under the fields (`use_attribute_docstrings`), but only those of its own models, and parses
the source of every class for it when the class is made: that takes half as long again as importing `design/` does.
"""

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
        summary: its first line, without the full stop.
        text: everything before its first section.
        fields: description of each field, including those of base classes.
    """

    summary: str
    text: str
    fields: Mapping[str, str]


def docstring_of(kind: type) -> Docstring:
    """Return the docstring of a class in its parts; they are empty where it has none."""
    fields: dict[str, str] = {}
    for base in reversed(kind.__mro__[:-1]):
        fields |= _fields(_own(base))
    text = _SECTION.split(_own(kind), maxsplit=1)[0].strip()
    return Docstring(text.partition("\n")[0].rstrip("."), text, fields)


def _own(kind: type) -> str:
    """Return the docstring of the class itself, without the signature that dataclasses get if they have none."""
    written = kind.__dict__.get("__doc__") or ""
    return "" if written.startswith(f"{kind.__name__}(") else inspect.cleandoc(written)


def _fields(text: str) -> dict[str, str]:
    _, *sections = _SECTION.split(text)
    named = zip(sections[::2], sections[1::2], strict=True)
    entries = [_ENTRY.findall(section) for name, section in named if name in ("Args", "Attributes")]
    return {name: " ".join(text.split()) for found in entries for names, text in found for name in names.split(", ")}
