"""Classify overrides: settings, settings of a sweep, search paths."""

from __future__ import annotations

import re

#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "plan", "shard", "on_error", "objective", "hydra")
#: Settings of a sweep, which a single point does not use.
_SWEEP_SETTINGS = ("study", "plan", "shard", "on_error", "hydra")


def is_setting(override: str) -> bool:
    """Return whether an override changes how points are run, not the points themselves."""
    return _has_key(override, SETTINGS)


def is_sweep_setting(override: str) -> bool:
    """Return whether an override changes how a sweep is run, and nothing that a single point uses."""
    return _has_key(override, _SWEEP_SETTINGS)


def is_search_path(override: str) -> bool:
    """Return whether an override sets the places where Hydra looks for options."""
    return override.lstrip("+").startswith("hydra.searchpath=")


def _has_key(override: str, keys: tuple[str, ...]) -> bool:
    return re.match(rf"[+~]*({'|'.join(keys)})(?=[./@=]|$)", override) is not None
