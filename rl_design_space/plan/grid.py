"""Grids: all combinations of the values that sweep overrides list."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override

from rl_design_space._yaml import as_yaml
from rl_design_space.config.explain import explained
from rl_design_space.errors import ConfigError


def expand(overrides: Sequence[str], parser: OverridesParser) -> Iterator[tuple[str, ...]]:
    """Yield all combinations of the values that sweep overrides list; the last override of a key wins.

    Raises:
        ConfigError: an override cannot be parsed or enumerated.
    """
    return product(*axes(overrides, parser).values())


def axes(overrides: Sequence[str], parser: OverridesParser) -> dict[str, list[str]]:
    """Return one override per value, by key, in the order of the keys.

    Raises:
        ConfigError: an override cannot be parsed or enumerated, or matches nothing.
    """
    found: dict[str, list[str]] = {}
    with explained():
        for override in parser.parse_overrides(list(overrides)):
            if override.is_sweep_override() and not override.is_discrete_sweep():
                raise ConfigError(f"{override.input_line}: an interval has no list of values; use choice or range")
            key = override.get_key_element()
            found.pop(override.key_or_group, None)  # +key and ~key replace key
            found[key] = [f"{key}={value}" for value in _values(override)]
    return found


def refuse_empty(overrides: Sequence[str], parser: OverridesParser) -> None:
    """Raise an error if a sweep override matches nothing; intervals always match.

    Raises:
        ConfigError: an override cannot be parsed, or matches nothing.
    """
    with explained():
        for override in parser.parse_overrides(list(overrides)):
            if override.is_discrete_sweep():
                _values(override)


def _values(override: Override) -> list[str]:
    """Return the values of an override, of which a sweep has several."""
    if not override.is_sweep_override():
        return [override.get_value_element_as_str()]
    values = list(override.sweep_string_iterator())
    if not values:
        raise ConfigError(f"{override.input_line}: matches nothing")
    return values


def as_overrides(sweeps: Mapping[str, Any]) -> list[str]:
    """Return a block of a study as overrides; strings are in the sweep grammar of Hydra, anything else is a value."""
    return [f"{key}={as_yaml(value)}" for key, value in sweeps.items()]
