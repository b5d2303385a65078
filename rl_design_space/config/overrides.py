"""Classify overrides: settings, settings of a sweep, search paths; and what all points of a sweep share."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import TypeVar

from hydra.core.override_parser.types import Override

from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import ABSENT_AS

Value = TypeVar("Value")

#: The design choices that are config groups: all fields of a point except `seed` and `task`.
OPTION_GROUPS = tuple(field.name for field in fields(DesignPoint) if field.name not in ("seed", "task"))
#: Values of the choices that a config may leave out, and the names of these options.
ABSENT = {field.name: field.metadata[ABSENT_AS] for field in fields(DesignPoint) if ABSENT_AS in field.metadata}
ABSENT_OPTION = "none"
#: Keys of the config that are not part of a design point.
SETTINGS = ("outputs", "threads", "tracking", "study", "plan", "shard", "on_error", "max_points", "objective", "hydra")
#: Settings of commands that run no points: where records are, and how many threads learn a point again.
READING_SETTINGS = ("outputs", "threads", "tracking")
#: Settings of a sweep, which a single point does not use.
_SWEEP_SETTINGS = ("study", "plan", "shard", "on_error", "max_points", "hydra")


def is_override(argument: str) -> bool:
    """Return whether an argument has the form of an override; Hydra itself refuses anything else."""
    return re.match(r"[+]*[A-Za-z_][^=]*=|~[A-Za-z_]", argument) is not None


def is_setting(override: str) -> bool:
    """Return whether an override changes how points are run, not the points themselves."""
    return _has_key(override, SETTINGS)


def is_reading_setting(override: str) -> bool:
    """Return whether an override is a setting that commands use which run no points."""
    return _has_key(override, READING_SETTINGS) or is_search_path(override)


def is_sweep_setting(override: str) -> bool:
    """Return whether an override changes how a sweep is run, and nothing that a single point uses."""
    return _has_key(override, _SWEEP_SETTINGS)


def is_of_study(override: str) -> bool:
    """Return whether an override chooses or changes a study."""
    return _has_key(override, ("study",))


def is_search_path(override: str) -> bool:
    """Return whether an override sets the places where Hydra looks for options."""
    return override.lstrip("+").startswith("hydra.searchpath=")


def with_absent(points: Sequence[Mapping[str, Value]]) -> list[Mapping[str, Value | str]]:
    """Return parameters of points, where some have a choice that others do without, with it in all of them."""
    missing = {group: ABSENT_OPTION for group in ABSENT if any(group in each for each in points)}
    return [{**missing, **each} for each in points] if missing else list(points)


def shared(overrides: Iterable[Override]) -> list[str]:
    """Return overrides as they apply to the config of a whole sweep, which holds its settings.

    Values that are swept over are left to the points. So is whether a point has a key: its options may be others than
    the defaults, as in `exploration=constant,linear exploration.k=0.02`. Other values count, because settings may
    interpolate them.
    """
    return [text for override in overrides if (text := _shared(override))]


def _shared(override: Override) -> str | None:
    text = override.input_line or ""
    if is_setting(text):
        return text
    depth = 0 if override.package or "/" in override.key_or_group else override.key_or_group.count(".")
    # What lies below the value of an option, as in `msa.lengths.0`, may not be there in the default option.
    if override.is_sweep_override() or depth > 1 or (depth and override.is_delete()):
        return None
    return f"++{text.lstrip('+')}" if depth else text


def _has_key(override: str, keys: tuple[str, ...]) -> bool:
    return re.match(rf"[+~]*({'|'.join(keys)})(?=[./@=]|$)", override) is not None
