"""Grids: all combinations of the values that sweep overrides list."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser

from rl_design_space._yaml import as_yaml
from rl_design_space.config.explain import explain
from rl_design_space.errors import ConfigError


def expand(overrides: Sequence[str], parser: OverridesParser) -> Iterator[tuple[str, ...]]:
    """All combinations of the values that sweep overrides list; the last override of a key counts.

    Raises:
        ConfigError: an override cannot be parsed or enumerated.
    """
    return product(*axes(overrides, parser).values())


def axes(overrides: Sequence[str], parser: OverridesParser) -> dict[str, list[str]]:
    """For each key, in order, one override for each value that it is to take.

    Raises:
        ConfigError: as above.
    """
    try:
        found: dict[str, list[str]] = {}
        for override in parser.parse_overrides(list(overrides)):
            key = override.get_key_element()
            if not override.is_sweep_override():
                values = [override.get_value_element_as_str()]
            elif override.is_discrete_sweep():
                values = list(override.sweep_string_iterator())
            else:
                raise ConfigError(f"{override.input_line}: an interval has no list of values; use choice or range")
            if not values:
                raise ConfigError(f"{override.input_line}: matches nothing")
            found.pop(override.key_or_group, None)  # +key and ~key take the place of key
            found[key] = [f"{key}={value}" for value in values]
    except Exception as error:
        if explained := explain(error):
            raise explained from error
        raise
    return found


def as_overrides(sweeps: Mapping[str, Any]) -> list[str]:
    """A block as one would type it; strings are Hydra's sweep grammar, anything else is a value."""
    return [f"{key}={as_yaml(value)}" for key, value in sweeps.items()]
