"""What `rl-design-space WORD …` does beside running design points: a module a word, with a `main(arguments)`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules


def words() -> list[str]:
    """The words there are."""
    return sorted(module.name for module in iter_modules(__path__))


def run(word: str, arguments: Sequence[str]) -> None:
    """Do what a word says; the rest of the command line is its own.

    Raises:
        ConfigError: something in the arguments cannot be used.
        SystemExit: with the exit status, if that is not 0.
    """
    import_module(f"{__name__}.{word}").main(arguments)
