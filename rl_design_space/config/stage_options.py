"""Values in a curriculum that name something: options in its stages, and carry rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, cast

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from omegaconf import OmegaConf

from rl_design_space.config.target import function_of
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError

#: The choice whose options hold such values, and the keys of these.
CURRICULUM, _STAGES, _CARRY = "curriculum", "stages", "carry"
_CHOICES = frozenset(field.name for field in fields(DesignPoint)) - {"seed", CURRICULUM}
Build = Callable[[str, Any], Any]


def named_values(node: Mapping[str, Any], build: Build) -> dict[str, Any]:
    """Return those values of a curriculum's config that name something, as what they name.

    In a stage, `representation: direction` names an option, as on the command line, and `{_target_: …}` describes one.

    Args:
        node: the config of a curriculum, plain Python values.
        build: builds a component from its key and config.

    Raises:
        ConfigError: there is no such option or function, or a value is not allowed.
    """
    found = {}
    if _CARRY in node:
        found[_CARRY] = _rule(f"{CURRICULUM}.{_CARRY}", node[_CARRY])
    if isinstance(node.get(_STAGES), list):
        stages = enumerate(node[_STAGES], 1)
        found[_STAGES] = tuple(_stage(f"{CURRICULUM}: stage {number}: ", stage, build) for number, stage in stages)
    return found


def _stage(place: str, stage: Any, build: Build) -> Any:
    if not isinstance(stage, Mapping):
        return stage
    return {key: _value(place, str(key), value, build) for key, value in stage.items()}


def _value(place: str, key: str, value: Any, build: Build) -> Any:
    if key == _CARRY:
        return _rule(f"{place}{key}", value)
    if key not in _CHOICES or not isinstance(value, (str, Mapping)):
        return value
    try:
        return build(key, _option(key, value) if isinstance(value, str) else value)
    except ConfigError as error:
        raise ConfigError(f"{place}{error}") from error


def _rule(key: str, name: Any) -> Any:
    """Return a carry rule of the package by its name, and any other as the function that it names."""
    return function_of(key, name) if isinstance(name, str) and "." in name else name


def _option(group: str, option: str) -> Any:
    """Return the content of an option's file.

    Raises:
        ConfigError: there is no such option, or choosing it means more than the content of its file.
    """
    repository = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader()).repository
    if not repository.config_exists(f"{group}/{option}"):
        raise ConfigError.unknown("option", option, repository.get_group_options(group), f"{group}=")
    found: Any = repository.load_config(f"{group}/{option}")
    listed = [default for default in found.defaults_list or () if not default.is_self()]
    node = OmegaConf.to_container(found.config)
    if listed or "${" in str(node):
        raise ConfigError.at(group, option, "has a defaults list or interpolations; write its values in the stage")
    return node
