"""Settings apply to a whole sweep: the config of each of its points has to agree with that of the sweep."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from omegaconf import DictConfig, OmegaConf

from rl_design_space._yaml import as_yaml
from rl_design_space.config.build import plain
from rl_design_space.config.overrides import SETTINGS, is_setting
from rl_design_space.errors import ConfigError

_COMPARED = tuple(key for key in SETTINGS if key not in ("study", "hydra"))
#: Keys of `hydra` that Hydra fills in, and those of `hydra.job`.
_FILLED_IN = ("runtime", "overrides")
_FILLED_IN_JOB = ("override_dirname", "config_name", "name", "id", "num")
#: The key or the resolver of an interpolation.
_INTERPOLATION = re.compile(r"\$\{\s*([^}:\s]*:?)")
#: Those that have the same value for all points: settings, values beside it, the environment.
_SHARED = re.compile(rf"({'|'.join(_COMPARED)})(\.|$)|\.\w|oc\.(env|decode):$")


class Agreement:
    """Compares the settings of points with those of their sweep.

    Args:
        sweep: composed config of the sweep; if None, no settings are compared.
    """

    def __init__(self, sweep: DictConfig | None) -> None:
        self._sweep = sweep
        self._values = {} if sweep is None else _values(sweep)

    def holds(self, config: DictConfig) -> bool:
        """Return whether a composed config has the settings of the sweep.

        Raises:
            ConfigError: a setting has no value, or interpolates one that there is not.
        """
        return self._sweep is None or _values(config) == self._values

    def check(self, config: DictConfig, overrides: Sequence[str]) -> None:
        """Check the settings of the point with these overrides.

        Raises:
            ConfigError: a setting differs from that of the sweep.
        """
        if self._sweep is None or self.holds(config):
            return
        # Choosing another option changes several values: the option says more than the first of them.
        options, values = (_options(config), _options(self._sweep)), (_values(config), self._values)
        key, value, of_sweep = next(
            (key, found.get(key), expected.get(key))
            for found, expected in (options, values)
            for key in {**found, **expected}
            if found.get(key) != expected.get(key)
        )
        name = " ".join(override for override in overrides if not is_setting(override)) or "of the defaults"
        expected = f"a setting applies to the whole sweep; {key}={as_yaml(of_sweep)} outside of the point {name}"
        raise ConfigError.at(key, value, expected)


def is_separable(config: DictConfig) -> bool:
    """Return whether the settings of a composed config are the same for all points: none interpolates their values."""
    text = str(OmegaConf.to_container(OmegaConf.masked_copy(config, list(_COMPARED))))
    return all(_SHARED.match(name) for name in _INTERPOLATION.findall(text))


def comparable(config: DictConfig, without: str) -> dict[str, Any]:
    """Return the content of a composed config without one of its top-level keys, and without what Hydra fills in."""
    node: Any = OmegaConf.to_container(config)
    node["hydra"] = _of_hydra(config)
    return {key: value for key, value in node.items() if key != without}


def _options(config: DictConfig) -> dict[str, Any]:
    """Return the names of the options that are chosen for settings."""
    choices = config.hydra.runtime.choices.items()
    return {group: option for group, option in choices if is_setting(f"{group}=") and group != "study"}


def _values(config: DictConfig) -> dict[str, Any]:
    """Return the value of each setting, by dotted key."""
    return dict(_flat({**{key: plain(config, key) for key in _COMPARED}, "hydra": _of_hydra(config)}))


def _of_hydra(config: DictConfig) -> dict[str, Any]:
    """Return what a user can set in `hydra`."""
    node: Any = OmegaConf.to_container(config.hydra)
    job = {key: value for key, value in node["job"].items() if key not in _FILLED_IN_JOB}
    return {**{key: value for key, value in node.items() if key not in _FILLED_IN}, "job": job}


def _flat(node: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    if not isinstance(node, Mapping):
        yield prefix, node
        return
    for key, value in node.items():
        yield from _flat(value, f"{prefix}.{key}" if prefix else str(key))
