"""Limits on YAML texts: a short text may describe billions of values, which aliases repeat.

A YAML parser reads such a text at once, but copying or merging its values takes for ever. So sizes are counted on the
parser's events, before any value exists.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from rl_design_space.errors import ConfigError

#: Maximum numbers of characters, of values with every alias written out, and of collections inside each other.
CHARACTERS, VALUES, DEPTH = 1_000_000, 100_000, 40
#: Parses in C where PyYAML was built with it.
_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_text(path: Path) -> str:
    """Return the text of a YAML file, cut where it is too large."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.read(CHARACTERS + 1)


def load_plain(text: str, name: str) -> Any:
    """Return the value that a YAML text from outside describes, of plain Python values.

    Args:
        text: the YAML.
        name: of its file, for messages.

    Raises:
        ConfigError: it is not YAML, or too large.
    """
    check_limits(text, name)
    try:
        return yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # ValueError: a date such as 2020-99-99
        raise ConfigError(f"{name}: not YAML: {' '.join(str(error).split())}") from error


def check_limits(text: str, name: str) -> None:
    """Refuse a YAML text that is too large; one that is not YAML is left to the parser, whose message has the place.

    Args:
        text: the YAML.
        name: of its file, for messages.

    Raises:
        ConfigError: it has too many characters or values, or too many collections inside each other.
    """
    if len(text) > CHARACTERS:
        raise ConfigError(f"{name}: has more than {CHARACTERS:,} characters")
    size = _Size(name)
    try:
        for event in yaml.parse(text, Loader=_Loader):
            size.add(event)
    except yaml.YAMLError:
        return


class _Size:
    """The number of values and the depth of a YAML text, counted event by event.

    Args:
        name: of its file, for messages.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        #: (anchor, values, depth below) of each open collection; the first is the document.
        self._open: list[tuple[str | None, int, int]] = [(None, 0, 0)]
        #: (values, depth) of what each anchor names.
        self._anchored: dict[str, tuple[int, int]] = {}

    def add(self, event: yaml.Event) -> None:
        """Count an event.

        Raises:
            ConfigError: there are too many by now.
        """
        if isinstance(event, yaml.CollectionStartEvent):
            self._open.append((event.anchor, 1, 0))
            self._check(0, 0)
        elif isinstance(event, yaml.CollectionEndEvent):
            self._close(*self._open.pop())
        elif isinstance(event, yaml.AliasEvent):
            # An unknown one is inside what it names, or an error for the parser.
            self._count(*self._anchored.get(event.anchor or "", (VALUES + 1, 0)))
        elif isinstance(event, yaml.ScalarEvent):
            self._close(event.anchor, 1, 0)

    def _close(self, anchor: str | None, values: int, depth: int) -> None:
        if anchor:
            self._anchored[anchor] = (values, depth)
        self._count(values, depth)

    def _count(self, values: int, depth: int) -> None:
        """Count a value inside the innermost open collection."""
        anchor, before, deepest = self._open.pop()
        self._open.append((anchor, before + values, max(deepest, depth + 1)))
        self._check(before + values, depth)

    def _check(self, values: int, depth: int) -> None:
        if values > VALUES:
            raise ConfigError(f"{self._name}: describes more than {VALUES:,} values, with what its aliases repeat")
        if len(self._open) + depth > DEPTH:
            raise ConfigError(f"{self._name}: has more than {DEPTH} collections inside each other")
