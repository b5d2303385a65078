"""Grids: all combinations of the values that sweep overrides list."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override

from rl_design_space._yaml import as_yaml
from rl_design_space.config.explain import explained
from rl_design_space.config.grammar import parse, sweep_size
from rl_design_space.errors import ConfigError

#: Maximum number of combinations that a sweep plans unless `max_points` says otherwise; planning so many takes minutes.
MAX_POINTS = 100_000


class Grid:
    """All combinations of the values that sweep overrides list; the last override of a key wins.

    Args:
        overrides: the overrides.
        parser: parses them.

    Raises:
        ConfigError: an override cannot be parsed or enumerated, or matches nothing.
    """

    def __init__(self, overrides: Sequence[str], parser: OverridesParser) -> None:
        self._overrides = _last(overrides, parser)
        #: Number of combinations; it may be more than `len` can return.
        self.size = math.prod(map(sweep_size, self._overrides))

    def __iter__(self) -> Iterator[tuple[str, ...]]:
        return product(*(_axis(override) for override in self._overrides))


def refuse_large(combinations: int, max_points: int) -> None:
    """Refuse a sweep of very many combinations unless it was asked for by number.

    Raises:
        ConfigError: there are more combinations than `max_points`.
    """
    if combinations > max_points:
        raise ConfigError(
            f"{combinations:,} combinations, more than max_points={max_points}; "
            f"if that is what you want, add max_points={combinations}"
        )


def axes(overrides: Sequence[str], parser: OverridesParser) -> dict[str, list[str]]:
    """Return one override per value, by key, in the order of the keys.

    Raises:
        ConfigError: an override cannot be parsed or enumerated, or matches nothing.
    """
    return {override.get_key_element(): _axis(override) for override in _last(overrides, parser)}


def refuse_empty(overrides: Sequence[str], parser: OverridesParser) -> None:
    """Raise an error if a sweep override matches nothing; intervals always match.

    Raises:
        ConfigError: an override cannot be parsed, or matches nothing.
    """
    with explained():
        for override in parse(overrides, parser):
            _refuse_nothing(override)


def _last(overrides: Sequence[str], parser: OverridesParser) -> list[Override]:
    """Return the last override of each key."""
    found: dict[str, Override] = {}
    with explained():
        for override in parse(overrides, parser):
            if override.is_sweep_override() and not override.is_discrete_sweep():
                raise ConfigError(f"{override.input_line}: an interval has no list of values; use choice or range")
            _refuse_nothing(override)
            found.pop(override.key_or_group, None)  # +key and ~key replace key
            found[override.get_key_element()] = override
    return list(found.values())


def _refuse_nothing(override: Override) -> None:
    if sweep_size(override) == 0:
        raise ConfigError(f"{override.input_line}: matches nothing")


def _axis(override: Override) -> list[str]:
    """Return one override per value."""
    if not override.is_sweep_override():
        return [f"{override.get_key_element()}={override.get_value_element_as_str()}"]
    return [f"{override.get_key_element()}={value}" for value in override.sweep_string_iterator()]


def as_overrides(sweeps: Mapping[str, Any]) -> list[str]:
    """Return a block of a study as overrides; strings are in the sweep grammar of Hydra, anything else is a value."""
    return [f"{key}={as_yaml(value)}" for key, value in sweeps.items()]
