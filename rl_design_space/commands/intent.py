"""What a command line is to run, a point or a sweep, and with which sweeper: its overrides and its files decide."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import NamedTuple

import hydra
from hydra.core.override_parser.types import Override
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from rl_design_space._yaml import as_yaml
from rl_design_space.config import user_config
from rl_design_space.config.compose import CONFIG_NAME, Composer, shipped_config
from rl_design_space.config.explain import explained
from rl_design_space.config.overrides import is_search_path, shared
from rl_design_space.errors import ConfigError

OWN_SWEEPERS = ("design", "race")
#: Package of our sweeper and launchers.
_OURS = "hydra_plugins.rl_design_space."
#: Keys that make a command a sweep.
_SWEEPING = ("study", "plan", "shard")
#: Their values that do not.
_UNUSED = ("null", "false", "")


class Intent(NamedTuple):
    """What a command line is to run.

    Attributes:
        multirun: whether it asks Hydra for a sweep.
        sweeps: overrides of the command line or settings of files that need our sweeper, e.g. `study=table4`.
        sweeper: name of the sweeper.
        own_sweeper: whether it is one of ours.
    """

    multirun: bool
    sweeps: tuple[str, ...]
    sweeper: str
    own_sweeper: bool


def intent_of(overrides: Sequence[Override], config_name: str | None = None) -> Intent:
    """Return what a command line is to run. The shipped files leave that to its overrides; those of the user need not.

    Args:
        overrides: the overrides of the command line.
        config_name: name of the primary config; if None, that of the shipped one.

    Raises:
        ConfigError: an override or a file cannot be used.
    """
    texts = [override.input_line or "" for override in overrides]
    if user_config.user_folder() or config_name or any(is_search_path(text) or _adds_to_hydra(text) for text in texts):
        return _of_files(overrides, config_name or CONFIG_NAME)
    values = _values(overrides)
    sweeper = values.get("hydra/sweeper", OWN_SWEEPERS[0])
    return Intent(
        values.get("hydra.mode", "") == RunMode.MULTIRUN.name,
        tuple(f"{key}={values[key]}" for key in _SWEEPING if values.get(key, "") not in _UNUSED),
        sweeper,
        sweeper in OWN_SWEEPERS,
    )


def _adds_to_hydra(text: str) -> bool:
    """Return whether an override adds a key to the sweeper or launcher; params of a sweeper are added by design."""
    return text.startswith(("+hydra.sweeper.", "++hydra.sweeper.", "+hydra.launcher.", "++hydra.launcher.")) and not (
        text.lstrip("+").startswith("hydra.sweeper.params.")
    )


def _of_files(overrides: Sequence[Override], config_name: str) -> Intent:
    one_value = [override for override in overrides if not override.is_sweep_override()]
    with shipped_config():
        places = [text for override in one_value if is_search_path(text := override.input_line or "")]
        config = Composer(places, config_name).config(shared(one_value))
    for part in ("sweeper", "launcher"):
        _check_keys(f"hydra.{part}", config.hydra[part])
    swept = _values([override for override in overrides if override.is_sweep_override()])
    values = {key: swept.get(key) or value for key, value in _settings(config).items()}
    return Intent(
        config.hydra.mode == RunMode.MULTIRUN,
        tuple(f"{key}={value}" for key, value in values.items() if value not in _UNUSED),
        str(config.hydra.runtime.choices["hydra/sweeper"]),
        str(config.hydra.sweeper.get("_target_")).startswith(_OURS),
    )


def _check_keys(prefix: str, node: DictConfig) -> None:
    """Check the keys of our sweeper or launcher, which Hydra looks at when a sweep begins.

    Raises:
        ConfigError: there is no such key.
    """
    target = str(node.get("_target_"))
    if target.startswith(_OURS):
        known = [*inspect.signature(hydra.utils.get_class(target)).parameters]
        for key in node:
            if key not in known and not str(key).startswith("_"):
                raise ConfigError.unknown(f"key in {target.rpartition('.')[2]}", str(key), known, f"{prefix}.")


def _values(overrides: Sequence[Override]) -> dict[str, str]:
    """Return the values of overrides as they are written, by key."""
    return {override.key_or_group: (override.input_line or "").partition("=")[2] for override in overrides}


def _settings(config: DictConfig) -> dict[str, str]:
    """Return what a composed config has at the keys that make a command a sweep."""
    with explained():
        study = config.hydra.runtime.choices.get("study") or OmegaConf.select(config, "study")
        return {"study": as_yaml(study), **{key: as_yaml(OmegaConf.select(config, key)) for key in _SWEEPING[1:]}}
