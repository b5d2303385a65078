"""Files and commands in the fenced blocks of a documentation page."""

from __future__ import annotations

import re
import shlex
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from markdown_it import MarkdownIt

from rl_design_space.commands import words as subcommands
from rl_design_space.commands.figure_words import WORDS
from tests.command_runner import PATIENCE, SCRIPTS, Completed, environment

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
    program, *arguments = words
    unchanged = set(arguments) & {*subcommands.names(), *WORDS, "--help", "-h", "--hydra-help"}
    small = () if unchanged else SMALL
    return subprocess.run(
        [str(SCRIPTS / program), *arguments, *small],
        cwd=folder,
        env=environment(folder),
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


def commands_as_written(page: Path) -> list[str]:
    """Return the commands of a page as a reader would copy them, from blocks of `sh` and from inline code."""
    lines: list[str] = []
    for token in MarkdownIt("commonmark").enable("table").parse(page.read_text(encoding="utf-8")):
        if token.type == "fence" and token.info == "sh":
            lines += token.content.replace("\\\n", " ").splitlines()
        lines += [child.content for child in token.children or () if child.type == "code_inline"]
    return [line for line in lines if line.partition(" ")[0] in PROGRAMS]


def seen_by_the_shell(line: str) -> str:
    """Return the characters of a command that a shell, bash or zsh, does not pass on as they are."""
    unquoted = re.sub(r"\\.|'[^']*'", "", line).partition(" #")[0]
    expanded = re.findall(r"`|\$(?!\w)", unquoted)  # variables are meant
    return "".join([*expanded, *re.findall(r"[*?\[\]{}~!;|&<>()]", re.sub(r'"[^"]*"', "", unquoted))])
