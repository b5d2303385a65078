"""What the comments of a YAML file say of it and of its keys."""

from __future__ import annotations

import re
from collections.abc import Iterator

import yaml

#: Comments for Hydra (`# @package …`) and for editors (`# yaml-language-server: …`).
_FOR_PROGRAMS = re.compile(r"#\s*(@|yaml-language-server:)")
#: The end of a sentence: not of an abbreviation, and a new one begins.
_SENTENCE_END = re.compile(r"(?<=[.?!])(?<!e\.g\.)(?<!i\.e\.)\s+(?=[^a-z\s])")


def leading_comment(text: str) -> str:
    """The comment that a file begins with, as one paragraph; empty if there is none."""
    said: list[str] = []
    for line in map(str.strip, text.splitlines()):
        if _FOR_PROGRAMS.match(line) or (not line and not said):
            continue
        if not line.startswith("#"):
            break
        said.append(line.lstrip("#").strip())
    return " ".join(filter(None, said))


def first_sentence(text: str) -> str:
    """The first sentence of a paragraph, without its full stop."""
    return _SENTENCE_END.split(text, maxsplit=1)[0].strip().rstrip(".")


def key_comments(text: str) -> dict[str, str]:
    """What is said of each key, by its dotted name: the comment behind its value, or else right above it.

    Entries of a `defaults` list count as keys, `defaults.world` for one.

    Raises:
        yaml.YAMLError: the file cannot be read.
    """
    lines = text.splitlines()
    return {key: said for key, start, end in _keys(yaml.compose(text)) if (said := _comment(lines, start, end))}


def _keys(node: yaml.Node | None, prefix: str = "") -> Iterator[tuple[str, yaml.Mark, yaml.Mark]]:
    """Dotted name of every key, where it begins, and where its value ends, or begins if that is a block below it."""
    if isinstance(node, yaml.SequenceNode) and prefix == "defaults.":
        for entry in node.value:
            yield from _keys(entry, prefix)
    if not isinstance(node, yaml.MappingNode):
        return
    for key, value in node.value:
        name = f"{prefix}{key.value}"
        block = isinstance(value, yaml.CollectionNode) and not value.flow_style
        yield name, key.start_mark, key.end_mark if block else value.end_mark
        yield from _keys(value, f"{name}.")


def _comment(lines: list[str], start: yaml.Mark, end: yaml.Mark) -> str:
    if end.line < len(lines) and (behind := re.match(r":?\s*#\s*(.*)", lines[end.line][end.column :])):
        return behind[1].strip()
    above: list[str] = []
    line = start.line - 1
    while line >= 0 and (found := re.match(r"\s*#\s*(.*)", lines[line])):
        above.insert(0, found[1].strip())
        line -= 1
    # A comment that begins the file is about the file.
    return " ".join(above) if line >= 0 else ""
