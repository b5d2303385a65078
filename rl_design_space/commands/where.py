"""Values of parameters on the command line: `--where exploration=linear world.size=10,20`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rl_design_space.errors import ConfigError


def where_of(words: Sequence[str], flag: str = "--where") -> tuple[dict[str, list[Any]], list[str]]:
    """Return the values of a flag by name, and the settings that follow them on the command line.

    Raises:
        ConfigError: a word is not KEY=VALUE, in Hydra's grammar for sweeps, or a key is named twice.
    """
    import yaml
    from hydra.core.override_parser.overrides_parser import OverridesParser

    from rl_design_space.config.overrides import is_setting
    from rl_design_space.plan.grid import axes

    if unknown := [word for word in words if "=" not in word]:
        raise ConfigError(f"{flag} {unknown[0]}: should be KEY=VALUE, such as exploration=linear")
    named: dict[str, str] = {}
    for word in words:
        key, _, values = word.partition("=")
        if key in named:
            raise ConfigError(f"{flag} {named[key]} {word}: should be one, such as {flag} {named[key]},{values}")
        named[key] = word
    chosen = axes([word for word in words if not is_setting(word)], OverridesParser.create()) if words else {}
    where = {key: [yaml.safe_load(each.partition("=")[2]) for each in values] for key, values in chosen.items()}
    return where, list(filter(is_setting, words))
