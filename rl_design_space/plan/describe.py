"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import ABSENT_AS, is_listed

_NOTHING = object()
#: Yields names and values of the fields of an option.
_Fields = Callable[[Any], Iterator[tuple[str, Any]]]


def parameters(point: DesignPoint) -> dict[str, Any]:
    """Return every value of a point by its dotted name, as on the command line, see `design.identity.is_listed`."""
    return dict(_flat("", point, _listed))


def flat(key: str, value: Any) -> dict[str, Any]:
    """Return every value of a component by its dotted name below a key; those that are not listed, too."""
    return dict(_flat(key, value, _all))


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


def _flat(key: str, value: Any, fields_of: _Fields) -> Iterator[tuple[str, Any]]:
    if not is_dataclass(value):
        yield key, _config(value)
        return
    for name, inner in fields_of(value):
        yield from _flat(f"{key}.{name}" if key else name, inner, fields_of)


def _config(value: Any) -> Any:
    if is_dataclass(value):
        target = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"_target_": target} | {name: _config(inner) for name, inner in _listed(value)}
    return list(value) if isinstance(value, tuple) else value


def _all(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        yield field.name, getattr(option, field.name)


def _listed(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        value = getattr(option, field.name)
        if is_listed(field, value):
            yield field.name, value
