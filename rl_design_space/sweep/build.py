"""From a composed config to validated values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pkgutil import resolve_name
from typing import Annotated, Any, TypeVar

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from pydantic import Field, ValidationError
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.sweep.explain import explain, invalid
from rl_design_space.tracking import Tracking

Built = TypeVar("Built")

#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "hydra")


def is_setting(override: str) -> bool:
    """Whether an override concerns how points are run, not the points."""
    return re.match(rf"[+~]*({'|'.join(SETTINGS)})(?=[./@=]|$)", override) is not None


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Settings:
    """How a point is run, which does not change its result."""

    outputs: Annotated[str, Field(min_length=1)]
    threads: Annotated[int, Field(ge=1)] | None
    tracking: Tracking


def build_settings(config: DictConfig) -> Settings:
    """The settings of a composed config.

    Raises:
        ConfigError: as `build_point`.
    """
    names = [field.name for field in fields(Settings)]
    return _construct(Settings, {name: build_component(config, name) for name in names}, names)


def build_point(config: DictConfig) -> DesignPoint:
    """The design point that a composed config describes.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    choices = [field.name for field in fields(DesignPoint)]
    for key in config:
        if key not in (*choices, *SETTINGS):
            raise ConfigError.unknown("key", str(key), [*choices, *SETTINGS])
    return _construct(DesignPoint, {choice: build_component(config, choice) for choice in choices}, choices)


def build_component(config: DictConfig, key: str) -> Any:
    """The value at one top-level key: what its `_target_` makes of its fields, or the plain value.

    Raises:
        ConfigError: as `build_point`.
    """
    return build(key, plain(config, key))


def build(key: str, node: Any) -> Any:
    """The same for a node that is plain Python already; `key` is where it stands."""
    if not isinstance(node, Mapping):
        return node
    if "_target_" not in node:
        raise ConfigError.at(f"{key}._target_", "???", "should name the class of this option")
    try:
        kind = resolve_name(node["_target_"])
    except (ImportError, AttributeError, ValueError, TypeError) as error:
        raise ConfigError.at(f"{key}._target_", node["_target_"], f"cannot be imported: {error}") from error
    if not is_dataclass(kind):
        raise ConfigError.at(f"{key}._target_", node["_target_"], "should be a frozen dataclass")
    try:
        return instantiate(node, _convert_="all")
    except InstantiationException as error:
        if isinstance(error.__cause__, ValidationError):
            raise invalid(key, error.__cause__, [field.name for field in fields(kind)]) from error
        raise ConfigError(f"{key}: {error.__cause__ or error}".replace("\n", " ")) from error


def _construct(kind: type[Built], parts: Mapping[str, Any], known: list[str]) -> Built:
    try:
        return kind(**parts)
    except ValidationError as error:
        raise invalid("", error, known) from error


def plain(config: DictConfig, key: str) -> Any:
    """The value at a top-level key as plain Python, everything resolved.

    Raises:
        ConfigError: a value is still `???`, or an interpolation finds nothing.
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
