"""Blocks of a study as overrides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin, get_type_hints

from rl_design_space._yaml import as_yaml
from rl_design_space.config.compose import Composer
from rl_design_space.config.overrides import OPTION_GROUPS, is_setting
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.plan.grid import as_overrides, axes


def block_overrides(sweeps: Mapping[str, Any], more: Sequence[str], composer: Composer) -> list[str]:
    """Return a block as overrides.

    Strings are in the sweep grammar of Hydra. A list is a sweep over its elements, as `[1, 2, 3]` is for `task.goals`,
    unless the key takes a list itself, as `msa.lengths` and `world.size` do: there, only a list of lists is a sweep.
    Anything else is a value.

    Args:
        sweeps: the block.
        more: overrides of the command line.
        composer: composes the components that keys belong to.

    Raises:
        ConfigError: a list is empty, or the options of a choice cannot be enumerated.
    """
    choices = [f"{key}={_listed(value)}" for key, value in sweeps.items() if key in OPTION_GROUPS]
    overrides = []
    for key, value in sweeps.items():
        if isinstance(value, list) and _is_sweep(key, value, [*choices, *more], composer):
            if not value:
                raise ConfigError(f"{key}=[]: matches nothing")
            overrides.append(f"{key}={_listed(value)}")
        else:
            overrides += as_overrides({key: value})
    return [*overrides, *more]


def refuse_settings(sweeps: Mapping[str, Any]) -> None:
    """Refuse settings in a block: they apply to all points.

    Raises:
        ConfigError: a key is that of a setting.
    """
    for key, value in sweeps.items():
        if is_setting(f"{key}="):
            raise ConfigError.at(key, value, "a setting applies to the whole sweep; give it on the command line")


def _listed(value: Any) -> str:
    return ",".join(map(as_yaml, value)) if isinstance(value, list) else as_yaml(value)


def _is_sweep(key: str, value: list[Any], overrides: Sequence[str], composer: Composer) -> bool:
    """Return whether a list holds the values of a sweep, and is not itself a value."""
    return any(isinstance(each, list) for each in value) or not any(
        _takes_list(hint) for hint in _hints(key, overrides, composer)
    )


def _hints(key: str, overrides: Sequence[str], composer: Composer) -> Iterator[Any]:
    """Yield the types of a key: one for each option that the overrides choose; Any if its type is unknown."""
    field, _, name = key.partition(".")
    hints = get_type_hints(DesignPoint)
    if not name:
        yield hints.get(field, Any)
        return
    if field not in hints:
        yield Any
        return
    chosen = axes([override for override in overrides if override.startswith(f"{field}=")], composer.parser)
    for option in chosen.get(field) or [""]:
        component = composer.parts([option] if option else []).values[field]
        yield get_type_hints(type(component)).get(name, Any)


def _takes_list(hint: Any) -> bool:
    kind = get_origin(hint) or hint
    if kind is Any or (isinstance(kind, type) and kind is not str and issubclass(kind, Sequence)):
        return True
    return any(map(_takes_list, get_args(hint)))
