"""The arguments of a command line, before Hydra gets them."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

from rl_design_space.sweep.build import is_setting
from rl_design_space.sweep.compose import check_options
from rl_design_space.sweep.explain import explain


def split_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a command line into what Hydra is to compose and, if it names a study, what the study's points take over.

    Flags, settings and everything that is not an override go to Hydra.
    """
    if not any(argument.startswith("study=") for argument in arguments):
        return list(arguments), []
    for_points = [argument for argument in arguments if _is_override(argument) and not is_setting(argument)]
    return [argument for argument in arguments if argument not in for_points], for_points


def check_arguments(arguments: Sequence[str]) -> None:
    """Check the overrides of a command line as far as that is possible before Hydra composes them.

    Raises:
        ConfigError: one is not an override, or gives a value where an option is needed.
    """
    try:
        check_options(OverridesParser.create().parse_overrides([a for a in arguments if _is_override(a)]))
    except HydraException as error:
        raise explain(error) or error from error


def _is_override(argument: str) -> bool:
    """Whether an argument is an override, rather than a flag or a flag's value."""
    return "=" in argument and re.match(r"[+~]*[A-Za-z_]", argument) is not None
