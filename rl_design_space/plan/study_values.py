"""The values of each parameter that the file of a study lists, without planning its points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from rl_design_space.config.build import plain
from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.block import block_overrides
from rl_design_space.plan.grid import axes
from rl_design_space.plan.planner import Planner


def study_values(name: str) -> dict[str, list[Any]]:
    """Return the values of each parameter in the order in which a study lists them; none if it cannot be read.

    Args:
        name: of the study; runs may be of one whose file is gone.
    """
    found: dict[str, list[Any]] = {}
    try:
        with shipped_config():
            for key, value in _values(name, Planner(), ()):
                found.setdefault(key, []).append(value)
    except ConfigError:
        return {}
    return found


def _values(name: str, planner: Planner, included_by: tuple[str, ...]) -> Iterator[tuple[str, Any]]:
    node = plain(planner.composer.config([f"study={name}"]), "study")
    if not isinstance(node, Mapping) or name in included_by:
        return
    for other in node.get("includes") or ():
        yield from _values(other, planner, (*included_by, name))
    for block in (node.get("blocks") or {}).values():
        overrides = block_overrides(block, (), planner.composer)
        for key, listed in axes(overrides, planner.composer.parser).items():
            for each in listed:
                yield key, yaml.safe_load(each.partition("=")[2])
