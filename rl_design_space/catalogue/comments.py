"""Descriptions of a YAML file and of its keys, from the comments in it."""

from __future__ import annotations

import re
from collections.abc import Iterator

import yaml

#: Comments for Hydra (`# @package …`) and for editors (`# yaml-language-server: …`).
_DIRECTIVE = re.compile(r"#\s*(@|yaml-language-server:)")
#: End of a sentence: no abbreviation, and followed by the beginning of another one.
_SENTENCE_END = re.compile(r"(?<=[.?!])(?<!e\.g\.)(?<!i\.e\.)\s+(?=[^a-z\s])")


def leading_comment(text: str) -> str:
    """Return the comment that a file begins with, as one paragraph; empty if there is none."""
    comment: list[str] = []
    for line in map(str.strip, text.splitlines()):
        if _DIRECTIVE.match(line) or (not line and not comment):
            continue
        if not line.startswith("#"):
            break
        comment.append(line.lstrip("#").strip())
    return " ".join(filter(None, comment))


def first_sentence(text: str) -> str:
    """Return the first sentence of a paragraph, without its full stop."""
    return _SENTENCE_END.split(text, maxsplit=1)[0].strip().rstrip(".")


def key_comments(text: str) -> dict[str, str]:
    """Return the comment of each key, by its dotted name: the one behind its value, or else the one right above it.

    Entries of a `defaults` list count as keys, `defaults.world` for one.

    Raises:
        yaml.YAMLError: the text is not YAML.
    """
    lines = text.splitlines()
    return {key: found for key, start, end in _keys(yaml.compose(text)) if (found := _comment(lines, start, end))}


def _keys(node: yaml.Node | None, prefix: str = "") -> Iterator[tuple[str, yaml.Mark, yaml.Mark]]:
    """Yield the dotted name of every key, where it begins, and where its value ends; of a block, where the key ends."""
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
    # A comment at the beginning of the file describes the file.
    return " ".join(above) if line >= 0 else ""
