"""Classify overrides: settings, settings of a sweep, search paths."""

from __future__ import annotations

import re
from dataclasses import fields

from rl_design_space.design import DesignPoint

#: The design choices that are config groups: all fields of a point except `seed` and `task`.
OPTION_GROUPS = tuple(field.name for field in fields(DesignPoint) if field.name not in ("seed", "task"))
#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "plan", "shard", "on_error", "max_points", "objective", "hydra")
#: Settings of a sweep, which a single point does not use.
_SWEEP_SETTINGS = ("study", "plan", "shard", "on_error", "max_points", "hydra")


def is_override(argument: str) -> bool:
    """Return whether an argument has the form of an override; Hydra itself refuses anything else."""
    return re.match(r"[+]*[A-Za-z_][^=]*=|~[A-Za-z_]", argument) is not None


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
