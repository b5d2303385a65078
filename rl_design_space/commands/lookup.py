"""What the commands that look things up understand."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

from rl_design_space.errors import ConfigError

_SEARCHPATH = "hydra.searchpath="


class Question(NamedTuple):
    """What is asked for.

    Attributes:
        subject: what to look up, or None.
        overrides: as for running points.
        searchpath: those of them that say where to look for options as well.
        config_dir: a folder with groups of the user's own.
        json: whether a program wants to read the answer.
    """

    subject: str | None
    overrides: tuple[str, ...]
    searchpath: tuple[str, ...]
    config_dir: str | None
    json: bool


def question(parser: argparse.ArgumentParser, arguments: Sequence[str], subject: str, about: str) -> Question:
    """Read the arguments of a command.

    Args:
        parser: what describes the command.
        arguments: behind its word.
        subject: name of the argument that says what to look up; optional if it begins with `[`.
        about: what it may be.

    Raises:
        ConfigError: a word is neither the subject nor an override.
    """
    optional = subject.startswith("[")
    parser.add_argument("subject", metavar=subject.strip("[]"), nargs="?" if optional else None, help=about)
    also = "as for running points, e.g. hydra.searchpath=[DIR]"
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help=also)
    parser.add_argument("--config-dir", "-cd", metavar="DIR", help="a folder with config groups of your own")
    parser.add_argument("--json", action="store_true", help="answer in JSON")
    found = parser.parse_intermixed_args(arguments)
    overrides = tuple(found.overrides)
    if optional and found.subject and "=" in found.subject:
        found.subject, overrides = None, (found.subject, *overrides)
    if words := [word for word in overrides if "=" not in word and not word.startswith("~")]:
        message = f"{words[0]}: not an override; they look like key=value, e.g. task.periods=50"
        if found.subject and "=" not in found.subject:
            message += f"; `rl-design-space show {found.subject}={words[0]}` tells of one option"
        raise ConfigError(message)
    searchpath = tuple(override for override in overrides if override.lstrip("+").startswith(_SEARCHPATH))
    return Question(found.subject, overrides, searchpath, found.config_dir, found.json)
