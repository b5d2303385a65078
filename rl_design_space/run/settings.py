"""Settings: how points are run, where they are recorded."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields
from typing import Annotated, Any, Literal

import hydra
from hydra.errors import HydraException
from omegaconf import DictConfig
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import build_component, construct
from rl_design_space.config.compose import CONFIG_NAME, shipped_config
from rl_design_space.config.explain import explain
from rl_design_space.config.overrides import SETTINGS, is_setting
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS
from rl_design_space.tracking import MlflowTracking, Tracking


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


def settings_of(overrides: Sequence[str]) -> Settings:
    """The settings that these overrides of the configuration describe, e.g. `outputs=elsewhere`.

    Raises:
        ConfigError: an override is not understood, concerns a point, or its value is not allowed.
    """
    for override in overrides:
        if not is_setting(override):
            raise ConfigError(f"{override}: not a setting; this command takes {'=…, '.join(SETTINGS[:3])}=…")
    with shipped_config():
        try:
            return build_settings(hydra.compose(CONFIG_NAME, list(overrides)))
        except HydraException as error:
            raise explain(error) or error from error


def store_of(overrides: Sequence[str]) -> MlflowTracking:
    """Where results are recorded by these settings.

    Raises:
        ConfigError: as `settings_of`, or nowhere.
    """
    tracking = settings_of(overrides).tracking
    if not isinstance(tracking, MlflowTracking):
        raise ConfigError("tracking=none: nothing is recorded, so there is no store")
    return tracking
