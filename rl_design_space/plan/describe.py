"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from types import FunctionType
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.design import DesignPoint, Stage, stages_of
from rl_design_space.design.identity import function_name


def parameters(point: DesignPoint) -> dict[str, Any]:
    """Return every value of a point by its dotted name, as on the command line; none of a curriculum without stages."""
    return {key: value for field in present_fields(point) for key, value in _flat(field, getattr(point, field))}


def resolved_config(point: DesignPoint) -> dict[str, Any]:
    """Return the point as a nested config, with every `_target_` and every value."""
    return {field: _config(getattr(point, field)) for field in present_fields(point)}


def present_fields(point: DesignPoint) -> list[str]:
    """Return the names of all choices of a point but the curriculum, if its periods have one stage."""
    return [field.name for field in fields(point) if field.name != "curriculum" or stages_of(point)]


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not is_dataclass(value):
        yield key, _text(value)
        return
    for field in fields(value):
        yield from _flat(f"{key}.{field.name}", getattr(value, field.name))


def _text(value: Any) -> Any:
    """Return a value as it is typed; a list of stages as one text, in which components are named by their classes."""
    if isinstance(value, Stage):
        return as_yaml({key: _text(inner) for key, inner in value.as_node().items()})
    if is_dataclass(value) and not isinstance(value, type):
        values = ", ".join(f"{field.name}={_text(getattr(value, field.name))}" for field in fields(value))
        return f"{type(value).__name__}({values})"
    if isinstance(value, tuple):
        texts = [_text(inner) for inner in value]
        return as_yaml(texts) if any(isinstance(inner, Stage) for inner in value) else texts
    return function_name(value) if isinstance(value, FunctionType) else value


def _config(value: Any) -> Any:
    if isinstance(value, Stage):
        return {key: _config(inner) for key, inner in value.as_node().items()}
    if is_dataclass(value):
        target = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"_target_": target} | {field.name: _config(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple):
        return [_config(inner) for inner in value]
    return function_name(value) if isinstance(value, FunctionType) else value
