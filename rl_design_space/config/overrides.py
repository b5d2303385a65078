"""Which keys of the configuration describe a design point, and which say how points are run."""

from __future__ import annotations

import re

#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "plan", "shard", "on_error", "objective", "hydra")
#: Settings of a whole sweep; a point that runs alone does not use them.
_OF_A_SWEEP = ("study", "plan", "shard", "on_error", "hydra")


def is_setting(override: str) -> bool:
    """Return whether an override concerns how points are run, not the points."""
    return _concerns(override, SETTINGS)


def is_of_a_sweep(override: str) -> bool:
    """Return whether an override concerns a whole sweep, and no point of it."""
    return _concerns(override, _OF_A_SWEEP)


def _concerns(override: str, keys: tuple[str, ...]) -> bool:
    return re.match(rf"[+~]*({'|'.join(keys)})(?=[./@=]|$)", override) is not None
