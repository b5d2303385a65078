"""Settings: how points are run and where they are recorded."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import MISSING, fields
from typing import Annotated, Any, Literal

import hydra
from omegaconf import DictConfig
from pydantic import AfterValidator, BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._paths import expanded
from rl_design_space._strict import STRICT
from rl_design_space.config.build import build, construct, plain
from rl_design_space.config.compose import CONFIG_NAME, shipped_config
from rl_design_space.config.explain import explain
from rl_design_space.config.grammar import parse
from rl_design_space.config.measure_name import ValueName, with_own_measures
from rl_design_space.config.overrides import READING_SETTINGS, is_reading_setting, is_setting
from rl_design_space.errors import ConfigError
from rl_design_space.learning.cores import available_threads
from rl_design_space.plan.grid import MAX_POINTS
from rl_design_space.tracking import MlflowTracking, Tracking

#: More threads than any machine has cores; the operating system refuses to start many more.
_MOST_THREADS = 1024


def _shard(text: Any) -> Any:
    """Convert `2/8` to (2, 8)."""
    if text is None or isinstance(text, tuple):
        return text
    found = re.fullmatch(r"([1-9]\d*)/([1-9]\d*)", str(text))
    if not found or int(found[1]) > int(found[2]):
        raise ValueError("should be i/N, from 1/N to N/N")
    return int(found[1]), int(found[2])


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Settings:
    """How points are run; no setting changes their results.

    Attributes:
        outputs: folder that all files are written to.
        threads: number of threads that learn; all cores if None.
        plan: whether to show the plan only.
        shard: which part of a sweep to run, as (number, number of parts); the whole sweep if None.
        max_points: maximum number of combinations that a sweep plans.
        on_error: whether a sweep continues or stops when a point fails.
        objective: the scalar or measure that a run returns, for sweepers that optimize.
        tracking: where results are recorded.
    """

    outputs: Annotated[str, Field(min_length=1), AfterValidator(expanded)]
    threads: Annotated[int, Field(ge=1, le=_MOST_THREADS)] | None
    plan: bool
    shard: Annotated[tuple[int, int] | None, BeforeValidator(_shard)]
    on_error: Literal["continue", "stop"]
    objective: ValueName
    tracking: Tracking
    max_points: Annotated[int, Field(ge=1)] = MAX_POINTS

    @property
    def learning_threads(self) -> int:
        """Number of threads that learn."""
        return self.threads or available_threads()


def build_settings(config: DictConfig) -> Settings:
    """Build the settings of a composed config.

    Raises:
        ConfigError: a key is missing, unknown or has a value that is not allowed.
    """
    # A config file of the user's that replaces the shipped one may be older than the settings with a default.
    given = [field.name for field in fields(Settings) if field.name in config or field.default is MISSING]
    nodes = with_own_measures({name: plain(config, name) for name in given})
    # The objective may be a mapping, which names no class.
    values = {name: node if name == "objective" else build(name, node) for name, node in nodes.items()}
    return construct(Settings, values)


def settings_of(overrides: Sequence[str]) -> Settings:
    """Build the settings that these overrides describe, e.g. `outputs=elsewhere`.

    Raises:
        ConfigError: an override cannot be parsed, or its value is not allowed.
    """
    parse(overrides)
    with shipped_config():
        try:
            return build_settings(hydra.compose(CONFIG_NAME, list(overrides)))
        except Exception as error:
            raise explain(error) or error from error


def reading_settings_of(overrides: Sequence[str]) -> Settings:
    """Build the settings of a command that runs no points.

    Raises:
        ConfigError: as for `settings_of`, or the command does not use a setting.
    """
    for override in overrides:
        if not is_reading_setting(override):
            wrong = "not a setting of this command, which" if is_setting(override) else "not a setting; this command"
            raise ConfigError(f"{override}: {wrong} takes {'=…, '.join(READING_SETTINGS)}=…")
    return settings_of(overrides)


def store_of(overrides: Sequence[str]) -> MlflowTracking:
    """Return the tracking store of the settings that these overrides describe.

    Raises:
        ConfigError: as for `reading_settings_of`, or the settings record nothing.
    """
    tracking = reading_settings_of(overrides).tracking
    if not isinstance(tracking, MlflowTracking):
        raise ConfigError("tracking=none: nothing is recorded, so there is no store")
    return tracking
