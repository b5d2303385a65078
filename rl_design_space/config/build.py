"""Build validated values from a composed config."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, TypeVar

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from pydantic import ValidationError

from rl_design_space.config.explain import explain, invalid
from rl_design_space.config.overrides import ABSENT, SETTINGS
from rl_design_space.config.stage_options import named_values
from rl_design_space.config.target import check_fields, class_of
from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import full_name, is_shipped
from rl_design_space.errors import ConfigError

Built = TypeVar("Built")

_CHOICES = frozenset(field.name for field in fields(DesignPoint))


def build_values(config: DictConfig) -> dict[str, Any]:
    """Build the value of each field of the design point that a composed config describes.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    choices = [field.name for field in fields(DesignPoint)]
    for key in config:
        if key not in (*choices, *SETTINGS):
            raise ConfigError.unknown("key", str(key), [*choices, *SETTINGS])
    # A config of the user's own may be older than a choice that has a value for its absence.
    built = [choice for choice in choices if choice in config or choice not in ABSENT]
    return {**ABSENT, **{choice: build_component(config, choice) for choice in built}}


def make_point(values: Mapping[str, Any]) -> DesignPoint:
    """Build a point from built values.

    Raises:
        ConfigError: the values contradict each other.
    """
    return construct(DesignPoint, values)


def build_component(config: DictConfig, key: str) -> Any:
    """Build the value at a top-level key: an instance of its `_target_`, or the plain value.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    return build(key, plain(config, key))


def build(key: str, node: Any) -> Any:
    """Build a value from a node of plain Python values: an instance of its `_target_`, or the node itself.

    Options inside of it are built as well, unless the class says with `builds_options` that it does so itself.

    Args:
        key: key of the node in the config, for messages.
        node: the node.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    if not isinstance(node, Mapping):
        return node
    if "_target_" not in node:
        raise ConfigError.at(f"{key}._target_", "???", "should name the class of this option")
    kind = class_of(key, node["_target_"])
    check_fields(key, kind, node)
    named = named_values(key, kind, node, build)
    node = {name: value for name, value in node.items() if name not in named}
    try:
        if key not in _CHOICES:
            builds_options = getattr(kind, "builds_options", False)
            values = {name: value for name, value in node.items() if name != "_target_"}
            if _is_simple(values, may_have_options=builds_options):
                return kind(**{name: _as_list(value) for name, value in values.items()})
            return instantiate(node, _convert_="all", _recursive_=not builds_options)
        prepared = instantiate(node, _convert_="all", _partial_=True)
        values = {name: _as_value(value) for name, value in prepared.keywords.items()} | named
        component = prepared.func(**values)
        twin = None if is_shipped(kind) else prepared.func(**values)
    except Exception as raised:
        error = raised.__cause__ or raised if isinstance(raised, InstantiationException) else raised
        if isinstance(error, ValidationError):
            raise invalid(key, error, kind, {**node, **named}) from raised
        raise ConfigError(f"{key}: {error}".replace("\n", " ")) from raised
    if twin is not None:
        _check_twin(key, component, twin)
    return component


def _check_twin(key: str, component: Any, twin: Any) -> None:
    """Refuse a component that differs from another one with the same values: its points would never be found again."""
    for field in fields(component):
        one, other = getattr(component, field.name), getattr(twin, field.name)
        if isinstance(one, (int, float, str, tuple)) and repr(one) != repr(other):
            raise ConfigError(
                f"{key}: {full_name(type(component))}.{field.name} is {one} when it is built, and {other} when it is "
                "built again from the same values; it must not draw random numbers, except from a generator that a "
                "field seeds"
            )


def _is_simple(value: Any, *, may_have_options: bool) -> bool:
    """Return whether Hydra would pass on a value as it is; it takes 15 ms for an option, and a ledger has a hundred."""
    if isinstance(value, Mapping):
        if not may_have_options and "_target_" in value:
            return False
        keys = [key for key in value if str(key).startswith("_") and key != "_target_"]
        return not keys and all(_is_simple(each, may_have_options=may_have_options) for each in value.values())
    if isinstance(value, (list, tuple)):
        return all(_is_simple(each, may_have_options=may_have_options) for each in value)
    return not isinstance(value, str) or ("${" not in value and value != "???")


def _as_list(value: Any) -> Any:
    """Copy a value, with lists instead of tuples, as Hydra does."""
    if isinstance(value, Mapping):
        return {key: _as_list(each) for key, each in value.items()}
    return [_as_list(each) for each in value] if isinstance(value, (list, tuple)) else value


def _as_value(value: Any) -> Any:
    """Convert lists to tuples, so that a component is hashable and equal to its copies."""
    return tuple(map(_as_value, value)) if isinstance(value, list) else value


def construct(kind: Callable[..., Built], values: Mapping[str, Any], prefix: str = "") -> Built:
    """Create an instance of a validated dataclass.

    Args:
        kind: the dataclass.
        values: its fields.
        prefix: key of the values in the config, for messages.

    Raises:
        ConfigError: a value is missing, unknown or not allowed.
    """
    try:
        return kind(**values)
    except ValidationError as error:
        raise invalid(prefix, error, kind, values) from error


def plain(config: DictConfig, key: str) -> Any:
    """Return the value at a top-level key as plain Python values, with all interpolations resolved.

    Raises:
        ConfigError: a value is still `???`, or an interpolation cannot be resolved.
    """
    if key not in config and not OmegaConf.is_missing(config, key):
        raise ConfigError(f"{key}: missing; leave it in, or name exactly one option")
    try:
        node = config[key]
        if OmegaConf.is_config(node):
            return OmegaConf.to_container(node, resolve=True, throw_on_missing=True)
        return node
    except OmegaConfBaseException as error:
        raise explain(error) or error from error
