"""The arguments of the commands `list` and `show`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

from rl_design_space.errors import ConfigError

_SEARCHPATH = "hydra.searchpath="


class Question(NamedTuple):
    """The parsed arguments.

    Attributes:
        subject: the choice, option, study or key to look up, or None.
        overrides: overrides, as for running points.
        searchpath: the `hydra.searchpath=…` among them.
        config_dir: config folder of the user.
        json: whether to answer in JSON.
    """

    subject: str | None
    overrides: tuple[str, ...]
    searchpath: tuple[str, ...]
    config_dir: str | None
    json: bool


def question(parser: argparse.ArgumentParser, arguments: Sequence[str], subject: str, about: str) -> Question:
    """Parse the arguments of a command.

    Args:
        parser: parser with the description of the command.
        arguments: the arguments after the name of the command.
        subject: name of the subject in the help; in brackets, the subject is optional.
        about: help text of the subject.

    Raises:
        ConfigError: an argument is neither the subject nor an override.
    """
    optional = subject.startswith("[")
    parser.add_argument("subject", metavar=subject.strip("[]"), nargs="?" if optional else None, help=about)
    overrides_help = "overrides, as for running points, e.g. hydra.searchpath=[DIR]"
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help=overrides_help)
    parser.add_argument("--config-dir", "-cd", metavar="DIR", help="folder with config groups of your own")
    parser.add_argument("--json", action="store_true", help="answer in JSON")
    found = parser.parse_intermixed_args(arguments)
    overrides = tuple(found.overrides)
    if optional and found.subject and "=" in found.subject:
        found.subject, overrides = None, (found.subject, *overrides)
    if words := [word for word in overrides if "=" not in word and not word.startswith("~")]:
        message = f"{words[0]}: not an override; overrides look like key=value, e.g. task.periods=50"
        if found.subject and "=" not in found.subject:
            message += f"; to show one option: `rl-design-space show {found.subject}={words[0]}`"
        raise ConfigError(message)
    searchpath = tuple(override for override in overrides if override.lstrip("+").startswith(_SEARCHPATH))
    return Question(found.subject, overrides, searchpath, found.config_dir, found.json)
