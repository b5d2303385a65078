"""Resolve the argument of `show`: `exploration=linear`, `study/table4`, `exploration.k` or `seed`."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from rl_design_space.catalogue.keys import Keys
from rl_design_space.catalogue.options import Options, Parameter
from rl_design_space.catalogue.search import HYDRA_GROUPS, Search
from rl_design_space.errors import ConfigError


class Subject(NamedTuple):
    """An option with its choice, a choice alone, or a key that is not a choice.

    Attributes:
        choice: name of the config group, or empty.
        option: name of the option, or empty.
        key: dotted name of the key, or empty.
    """

    choice: str = ""
    option: str = ""
    key: str = ""


def subject(search: Search, text: str) -> Subject:
    """Resolve the argument of `show`.

    Raises:
        ConfigError: the subject does not exist; names the nearest one that does.
    """
    groups = (*search.groups, *HYDRA_GROUPS)
    group, _, option = text.rpartition("/") if "=" not in text else text.partition("=")
    if text in groups:
        return Subject(choice=text)
    if option and (group or "=" in text):
        search.check(group, option)
        return Subject(group, option)
    known = (*groups, *Keys(search).names)
    if text.partition(".")[0] in known:
        return Subject(key=text)
    homes = [f"{group}={text}" for group in groups if text in search.options(group)]
    if homes:
        raise ConfigError(f"{text}: an option, not a choice; did you mean {' or '.join(homes)}?")
    raise ConfigError.unknown("choice or key", text, dict.fromkeys(known))


def parameters(search: Search, key: str) -> list[Parameter]:
    """Return the parameters of a key; for a key of a choice, that of each option which has it.

    Raises:
        ConfigError: the key does not exist.
    """
    top, _, name = key.partition(".")
    if top in search.groups:
        options = Options(search)
        each_option = [options.option(top, option) for option in search.options(top)]
        held = [(option.name, parameter) for option in each_option for parameter in option.parameters]
        found = [replace(each, name=f"{top}={option}") for option, each in held if each.name == key]
        known = {each.name for _, each in held}
    else:
        every = Keys(search).parameters(top)
        found = [each for each in every if not name or each.name == key]
        known = {each.name for each in every}
    if not found:
        raise ConfigError.unknown("key", key, known)
    return found
