"""The subcommands `rl-design-space WORD …`: one module per word, with a function `main(arguments)`."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

__all__ = ["names", "run", "summaries"]


def names() -> list[str]:
    """Return the words, sorted."""
    return sorted(module.name for module in iter_modules(__path__))


def summaries() -> dict[str, str]:
    """Return the first line of each module's docstring, by word, without importing the modules."""
    return {word: _first_line(Path(__path__[0], f"{word}.py")) for word in names()}


def run(word: str, arguments: Sequence[str]) -> None:
    """Run the subcommand of a word with the other arguments of the command line.

    Raises:
        ConfigError: an argument cannot be used.
        SystemExit: with the exit status, if that is not 0.
    """
    import_module(f"{__name__}.{word}").main(arguments)


def _first_line(file: Path) -> str:
    said = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return said.partition("\n")[0].rstrip(".")
