"""What `rl-design-space WORD …` does beside running design points: a module a word, with a `main(arguments)`."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules


def names() -> list[str]:
    """Return the words, sorted."""
    return sorted(module.name for module in iter_modules(__path__))


def summaries() -> dict[str, str]:
    """What each word does, as the first line of its module says; none of them is imported for it."""
    return {word: _first_line(Path(__path__[0], f"{word}.py")) for word in names()}


def run(word: str, arguments: Sequence[str]) -> None:
    """Do what a word says; the rest of the command line is its own.

    Raises:
        ConfigError: something in the arguments cannot be used.
        SystemExit: with the exit status, if that is not 0.
    """
    import_module(f"{__name__}.{word}").main(arguments)


def _first_line(file: Path) -> str:
    said = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return said.partition("\n")[0].rstrip(".")
