"""Files and commands in the fenced blocks of a documentation page."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt

from rl_design_space.commands import words as subcommands
from rl_design_space.commands.figure_words import WORDS
from tests.command_runner import Completed, completed

DOCS = Path(__file__).parent.parent / "docs"
PROGRAMS = ("rl-design-space", "rl-design-report")
#: Overrides that make a documented run short.
SMALL = ("task.periods=2", "task.trials=5", "threads=1")


class File(NamedTuple):
    """A fenced block whose info string names a file, as in `yaml mine/world/large.yaml`."""

    path: str
    text: str


class Typed(NamedTuple):
    """A command in a fenced block of `sh`."""

    words: tuple[str, ...]


def parts_of(page: Path) -> list[File | Typed]:
    """Return the files and commands of a page, from top to bottom."""
    return list(_parts(page.read_text(encoding="utf-8")))


def _parts(text: str) -> Iterator[File | Typed]:
    for token in MarkdownIt("commonmark").parse(text):
        language, _, path = token.info.partition(" ")
        if token.type == "fence" and path:
            yield File(path, token.content)
        elif token.type == "fence" and language == "sh":
            yield from _commands(token.content)


def _commands(text: str) -> Iterator[Typed]:
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words and words[0] in PROGRAMS:
            yield Typed(tuple(words))


def run(words: tuple[str, ...], folder: Path) -> Completed:
    """Run a documented command in a folder; learning and reports get the overrides of `SMALL`."""
    arguments = words[1:]
    unchanged = set(arguments) & {*subcommands.names(), *WORDS, "--help", "-h", "--hydra-help"}
    return completed(folder, *words, *(() if unchanged else SMALL))
