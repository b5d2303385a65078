"""Settings for commands that run no points."""

from __future__ import annotations

from collections.abc import Sequence

import hydra
from hydra.errors import HydraException

from rl_design_space.errors import ConfigError
from rl_design_space.sweep.build import SETTINGS, Settings, build_settings, is_setting
from rl_design_space.sweep.compose import CONFIG_NAME, shipped_config
from rl_design_space.sweep.explain import explain
from rl_design_space.tracking import MlflowTracking


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
