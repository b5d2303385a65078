"""From a composed config to validated values."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Annotated, Any, Literal, TypeVar

from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from pydantic import AfterValidator, BeforeValidator, Field, ValidationError
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.learning.names import SCALARS
from rl_design_space.sweep.explain import explain, invalid
from rl_design_space.sweep.target import check_fields, class_of
from rl_design_space.tracking import Tracking

Built = TypeVar("Built")

_CHOICES = frozenset(field.name for field in fields(DesignPoint))
#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "plan", "shard", "on_error", "objective", "hydra")
#: Those of them that belong to a sweep as a whole, so that a point that is run alone has no use for them.
_OF_A_SWEEP = ("study", "plan", "shard", "on_error", "hydra")


def is_setting(override: str) -> bool:
    """Whether an override concerns how points are run, not the points."""
    return _concerns(override, SETTINGS)


def is_of_a_sweep(override: str) -> bool:
    """Whether an override concerns a sweep as a whole, and none of its points alone."""
    return _concerns(override, _OF_A_SWEEP)


def _concerns(override: str, keys: tuple[str, ...]) -> bool:
    return re.match(rf"[+~]*({'|'.join(keys)})(?=[./@=]|$)", override) is not None


def _known_scalar(name: str) -> str:
    if name not in SCALARS:
        raise ValueError(f"should be among {', '.join(SCALARS)}")
    return name


def _shard(text: Any) -> Any:
    """`2/8` as (2, 8)."""
    if not isinstance(text, str):
        return text
    found = re.fullmatch(r"([1-9]\d*)/([1-9]\d*)", text)
    if not found or int(found[1]) > int(found[2]):
        raise ValueError("should be i/N, from 1/N to N/N")
    return int(found[1]), int(found[2])


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Settings:
    """How points are run, which does not change their results.

    Attributes:
        outputs: folder that everything is written into.
        threads: cores that learn, all if None.
        plan: show what would run, and stop.
        shard: which part of a sweep to run, and of how many, if not all.
        on_error: whether a sweep goes on when a point fails.
        objective: the scalar that a run returns, for sweepers that search.
        tracking: where results are recorded.
    """

    outputs: Annotated[str, Field(min_length=1)]
    threads: Annotated[int, Field(ge=1)] | None
    plan: bool
    shard: Annotated[tuple[int, int] | None, BeforeValidator(_shard)]
    on_error: Literal["continue", "stop"]
    objective: Annotated[str, AfterValidator(_known_scalar)]
    tracking: Tracking


def build_settings(config: DictConfig) -> Settings:
    """The settings of a composed config.

    Raises:
        ConfigError: as `build_values`.
    """
    return construct(Settings, {field.name: build_component(config, field.name) for field in fields(Settings)})


def build_values(config: DictConfig) -> dict[str, Any]:
    """The value of each field of the design point that a composed config describes.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    choices = [field.name for field in fields(DesignPoint)]
    for key in config:
        if key not in (*choices, *SETTINGS):
            raise ConfigError.unknown("key", str(key), [*choices, *SETTINGS])
    return {choice: build_component(config, choice) for choice in choices}


def make_point(values: Mapping[str, Any]) -> DesignPoint:
    """The point of these choices, each built.

    Raises:
        ConfigError: they do not go together.
    """
    return construct(DesignPoint, values)


def build_component(config: DictConfig, key: str) -> Any:
    """The value at one top-level key: what its `_target_` makes of its fields, or the plain value.

    Raises:
        ConfigError: as `build_values`.
    """
    return build(key, plain(config, key))


def build(key: str, node: Any) -> Any:
    """The same for a node that is plain Python already; `key` is where it stands."""
    if not isinstance(node, Mapping):
        return node
    if "_target_" not in node:
        raise ConfigError.at(f"{key}._target_", "???", "should name the class of this option")
    kind = class_of(key, node["_target_"])
    check_fields(key, kind, node)
    try:
        if key not in _CHOICES:
            return instantiate(node, _convert_="all")
        prepared = instantiate(node, _convert_="all", _partial_=True)
        return prepared.func(**{name: _as_value(value) for name, value in prepared.keywords.items()})
    except Exception as raised:
        error = raised.__cause__ or raised if isinstance(raised, InstantiationException) else raised
        if isinstance(error, ValidationError):
            raise invalid(key, error, [field.name for field in fields(kind)]) from raised
        raise ConfigError(f"{key}: {error}".replace("\n", " ")) from raised


def _as_value(value: Any) -> Any:
    """Lists as tuples: a component is a value, equal to its copies and with a hash."""
    return tuple(map(_as_value, value)) if isinstance(value, list) else value


def construct(kind: Callable[..., Built], values: Mapping[str, Any], prefix: str = "") -> Built:
    """A validated dataclass with these values.

    Raises:
        ConfigError: a value is missing, unknown or not allowed; `prefix` is where they stand.
    """
    try:
        return kind(**values)
    except ValidationError as error:
        raise invalid(prefix, error, [field.name for field in fields(kind)]) from error  # type: ignore[arg-type]


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
