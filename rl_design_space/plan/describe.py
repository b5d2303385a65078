"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import ABSENT_AS

_NOTHING = object()


def parameters(point: DesignPoint) -> dict[str, Any]:
    """Return every value of a point by its dotted name, as on the command line; without fields that are absent.

    A field that was added to an option later is absent while its value stands for that, see `design.identity`.
    """
    return flat("", point)


def flat(key: str, value: Any) -> dict[str, Any]:
    """Return every value of a component by its dotted name below a key."""
    return dict(_flat(key, value))


def absent_parameters(point: DesignPoint) -> set[str]:
    """Return the names of parameters that were added later and have the value that stands for their absence.

    Points recorded before have no such parameters, and points recorded since then have none either, so that both are
    compared as what they are: equal.
    """
    return {
        f"{choice.name}.{field.name}"
        for choice in fields(point)
        if is_dataclass(component := getattr(point, choice.name))
        for field in fields(component)
        if field.metadata.get(ABSENT_AS, _NOTHING) == getattr(component, field.name)
    }


def resolved_config(point: DesignPoint) -> dict[str, Any]:
    """Return the point as a nested config, with every `_target_` and every value."""
    return {field.name: _config(getattr(point, field.name)) for field in fields(point)}


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not is_dataclass(value):
        yield key, _config(value)
        return
    for name, inner in _present(value):
        yield from _flat(f"{key}.{name}" if key else name, inner)


def _config(value: Any) -> Any:
    if is_dataclass(value):
        target = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"_target_": target} | {name: _config(inner) for name, inner in _present(value)}
    return list(value) if isinstance(value, tuple) else value


def _present(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        value = getattr(option, field.name)
        if ABSENT_AS not in field.metadata or value != field.metadata[ABSENT_AS]:
            yield field.name, value
