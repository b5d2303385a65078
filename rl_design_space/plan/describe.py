"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from types import FunctionType
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.design import DesignPoint, Stage, Stages, stages_of
from rl_design_space.design.identity import ABSENT_AS, function_name


def parameters(point: DesignPoint) -> dict[str, Any]:
    """Return every value of a point by its dotted name, as on the command line; without fields that are absent.

    A field that was added to an option later is absent while its value stands for that, see `design.identity`.
    """
    return flat("", without_idle(point))


def flat(key: str, value: Any) -> dict[str, Any]:
    """Return every value of a component by its dotted name below a key."""
    return dict(_flat(key, value))


def resolved_config(point: DesignPoint) -> dict[str, Any]:
    """Return the point as a nested config, with every `_target_` and every value."""
    return {name: _config(value) for name, value in _present(without_idle(point))}


def present_fields(point: DesignPoint) -> list[str]:
    """Return the names of the choices of a point, without one that is absent."""
    return [name for name, _ in _present(without_idle(point))]


def without_idle(point: DesignPoint) -> DesignPoint:
    """Return the point without a curriculum that lists no other stage than the point itself."""
    return point if point.curriculum == Stages() or stages_of(point) else replace(point, curriculum=Stages())


def _flat(key: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not is_dataclass(value):
        yield key, _text(value)
        return
    for name, inner in _present(value):
        yield from _flat(f"{key}.{name}" if key else name, inner)


def _text(value: Any) -> Any:
    """Return a value as it is typed; a list of stages as one text, in which components are named by their classes."""
    if isinstance(value, Stage):
        return as_yaml({key: _text(inner) for key, inner in value.as_node().items()})
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}({', '.join(f'{name}={_text(inner)}' for name, inner in _present(value))})"
    if isinstance(value, tuple):
        texts = [_text(inner) for inner in value]
        return as_yaml(texts) if any(isinstance(inner, Stage) for inner in value) else texts
    return function_name(value) if isinstance(value, FunctionType) else value


def _config(value: Any) -> Any:
    if isinstance(value, Stage):
        return {key: _config(inner) for key, inner in value.as_node().items()}
    if is_dataclass(value):
        target = f"{type(value).__module__}.{type(value).__qualname__}"
        return {"_target_": target} | {name: _config(inner) for name, inner in _present(value)}
    if isinstance(value, tuple):
        return [_config(inner) for inner in value]
    return function_name(value) if isinstance(value, FunctionType) else value


def _present(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        value = getattr(option, field.name)
        if ABSENT_AS not in field.metadata or value != field.metadata[ABSENT_AS]:
            yield field.name, value
