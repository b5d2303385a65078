"""Values that name something: options in the stages of a curriculum or inside of another option, and carry rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, cast

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.global_hydra import GlobalHydra
from omegaconf import OmegaConf

from rl_design_space._yaml import as_yaml
from rl_design_space.config.overrides import ABSENT_OPTION
from rl_design_space.config.target import function_of
from rl_design_space.design import DesignPoint, Stages, Without
from rl_design_space.errors import ConfigError

#: The choices whose options hold such values, and the keys of these.
CURRICULUM, _STAGES, _CARRY = "curriculum", "stages", "carry"
_REPRESENTATION, _OF = "representation", "of"
_CHOICES = frozenset(field.name for field in fields(DesignPoint)) - {"seed", CURRICULUM}
_TARGET, _TASK = "_target_", "task"
#: Keys whose values in a stage are written with dots, unless they describe an option.
_NESTED = _CHOICES | {_TASK}
_EXAMPLE = "{world.size: 5, task.trials: 20, layout: scaled}"
Build = Callable[[str, Any], Any]


def named_values(key: str, kind: type, node: Mapping[str, Any], build: Build) -> dict[str, Any]:
    """Return those values of a component's config that name something, as what they name.

    In a stage, `representation: direction` names an option, as on the command line, and `{_target_: …}` describes one.
    So does `of: direction` in a representation that leaves out attributes of another one.

    Args:
        key: the choice.
        kind: class of the component.
        node: its config, plain Python values.
        build: builds a component from its key and config.

    Raises:
        ConfigError: there is no such option or function, or a value is not allowed.
    """
    if key == CURRICULUM:
        return _of_curriculum(node, build)
    if issubclass(kind, Without) and isinstance(node.get(_OF), str):
        return {_OF: _built(f"{key}.{_OF}", node[_OF], build)}
    return {}


def check_stages(option: str, curriculum: Any) -> None:
    """Refuse an option that lists no stage: it would say nothing, and its points would be those of `none`.

    Args:
        option: name of the option.
        curriculum: what it describes.

    Raises:
        ConfigError: it lists no stage.
    """
    if option != ABSENT_OPTION and isinstance(curriculum, Stages) and not curriculum.stages:
        expected = (
            f"{CURRICULUM}={option} should list a stage, as in [{_EXAMPLE}]; without stages, use {CURRICULUM}=none"
        )
        raise ConfigError.at(f"{CURRICULUM}.{_STAGES}", [], expected)


def _of_curriculum(node: Mapping[str, Any], build: Build) -> dict[str, Any]:
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
    if isinstance(value, Mapping) and _TARGET not in value and key in _NESTED:
        dotted = ", ".join(f"{key}.{name}: {as_yaml(each)}" for name, each in value.items()) or f"{key}: OPTION"
        raise ConfigError.at(f"{place}{key}", value, f"should be {dotted}")
    if key in _CHOICES and key != _TASK and not isinstance(value, (str, Mapping)) and not is_dataclass(value):
        raise ConfigError.at(f"{place}{key}", value, f"should be the name of an option; its fields: {key}.FIELD")
    if _choice(key) not in _CHOICES or not isinstance(value, (str, Mapping)):
        return value
    try:
        return _built(key, value, build)
    except ConfigError as error:
        raise ConfigError(f"{place}{error}") from error


def _choice(key: str) -> str:
    """Return the choice whose options a value may name."""
    return _REPRESENTATION if key == f"{_REPRESENTATION}.{_OF}" else key


def _built(key: str, value: str | Mapping[str, Any], build: Build) -> Any:
    """Return the component that a value names or describes."""
    return build(_choice(key), _option(key, value) if isinstance(value, str) else value)


def _rule(key: str, name: Any) -> Any:
    """Return a carry rule of the package by its name, and any other as the function that it names."""
    return function_of(key, name) if isinstance(name, str) and "." in name else name


def _option(key: str, option: str) -> Any:
    """Return the content of an option's file.

    Raises:
        ConfigError: there is no such option, or choosing it means more than the content of its file.
    """
    repository = cast(ConfigLoaderImpl, GlobalHydra.instance().config_loader()).repository
    group = _choice(key)
    if not repository.config_exists(f"{group}/{option}"):
        raise ConfigError.unknown("option", option, repository.get_group_options(group), f"{key}=")
    found: Any = repository.load_config(f"{group}/{option}")
    listed = [default for default in found.defaults_list or () if not default.is_self()]
    node = OmegaConf.to_container(found.config)
    if listed or "${" in str(node):
        raise ConfigError.at(key, option, "has a defaults list or interpolations; write its values in the stage")
    return node
