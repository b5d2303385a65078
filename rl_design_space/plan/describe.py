"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from types import FunctionType
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.design import DesignPoint, Stage, Stages, stages_of
from rl_design_space.design.identity import full_name, function_name, is_listed

_NOTHING = object()
#: Yields names and values of the fields of an option.
_Fields = Callable[[Any], Iterator[tuple[str, Any]]]


def parameters(point: DesignPoint) -> dict[str, Any]:
    """Return every value of a point by its dotted name, as on the command line, see `design.identity.is_listed`."""
    return dict(_flat("", without_idle(point), _listed))


def flat(key: str, value: Any) -> dict[str, Any]:
    """Return every value of a component by its dotted name below a key; those that are not listed, too."""
    return dict(_flat(key, value, _all))


def resolved_config(point: DesignPoint) -> dict[str, Any]:
    """Return the point as a nested config, with every `_target_` and every value."""
    return {name: _config(value) for name, value in _listed(without_idle(point))}


def present_fields(point: DesignPoint) -> list[str]:
    """Return the names of the choices of a point, without one that is absent."""
    return [name for name, _ in _listed(without_idle(point))]


def without_idle(point: DesignPoint) -> DesignPoint:
    """Return the point without a curriculum that lists no other stage than the point itself."""
    return point if point.curriculum == Stages() or stages_of(point) else replace(point, curriculum=Stages())


def _flat(key: str, value: Any, fields_of: _Fields) -> Iterator[tuple[str, Any]]:
    if not is_dataclass(value):
        yield key, _text(value)
        return
    if "." in key:  # a component inside of another one, which no option names
        yield key, full_name(type(value))
    for name, inner in fields_of(value):
        yield from _flat(f"{key}.{name}" if key else name, inner, fields_of)


def _text(value: Any) -> Any:
    """Return a value as it is typed; a list of stages as one text, in which components are named by their classes."""
    if isinstance(value, Stage):
        return as_yaml({key: _text(inner) for key, inner in value.as_node().items()})
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}({', '.join(f'{name}={_text(inner)}' for name, inner in _listed(value))})"
    if isinstance(value, tuple):
        texts = [_text(inner) for inner in value]
        return as_yaml(texts) if any(isinstance(inner, Stage) for inner in value) else texts
    return function_name(value) if isinstance(value, FunctionType) else value


def _config(value: Any) -> Any:
    if isinstance(value, Stage):
        return {key: _config(inner) for key, inner in value.as_node().items()}
    if is_dataclass(value):
        target = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"_target_": target} | {name: _config(inner) for name, inner in _listed(value)}
    if isinstance(value, tuple):
        return [_config(inner) for inner in value]
    return function_name(value) if isinstance(value, FunctionType) else value


def _all(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        yield field.name, getattr(option, field.name)


def _listed(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        value = getattr(option, field.name)
        if is_listed(field, value):
            yield field.name, value
