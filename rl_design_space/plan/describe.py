"""A design point as plain data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from types import FunctionType
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.design import DesignPoint, Stage, Stages, stages_of
from rl_design_space.design.identity import full_name, function_name, is_listed, is_shipped_name

_TARGET = "_target_"
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


def config_parameters(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return every value of a resolved config by its dotted name, an inner component by the name of its class.

    Nothing that the config names is imported, so that it may name classes that are not on this machine.
    """
    return {key: value for choice, node in config.items() for key, value in _flat_node(str(choice), node)}


def config_text(node: Any) -> Any:
    """Return a value of a resolved config as `parameters` has it."""
    if _is_component(node):
        values = (f"{name}={config_text(inner)}" for name, inner in node.items() if name != _TARGET)
        return f"{str(node[_TARGET]).rpartition('.')[2]}({', '.join(values)})"
    if isinstance(node, list):
        stages = any(isinstance(inner, Mapping) and not _is_component(inner) for inner in node)
        return as_yaml([_stage_text(inner) for inner in node]) if stages else [config_text(inner) for inner in node]
    return node


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
        return {_TARGET: target} | {name: _config(inner) for name, inner in _listed(value)}
    if isinstance(value, tuple):
        return [_config(inner) for inner in value]
    return function_name(value) if isinstance(value, FunctionType) else value


def _flat_node(key: str, node: Any) -> Iterator[tuple[str, Any]]:
    is_choice = "." not in key
    if not (_is_component(node) or (is_choice and isinstance(node, Mapping))):
        yield key, node
        return
    if not is_choice:
        target = str(node[_TARGET])
        yield key, target.rpartition(".")[2] if is_shipped_name(target) else target
    for name, inner in node.items():
        if name != _TARGET:
            yield from _flat_node(f"{key}.{name}", inner)


def _is_component(node: Any) -> bool:
    return isinstance(node, Mapping) and _TARGET in node


def _stage_text(node: Any) -> Any:
    if not isinstance(node, Mapping) or _is_component(node):
        return config_text(node)
    return {key: config_text(inner) for key, inner in node.items()}


def _all(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        yield field.name, getattr(option, field.name)


def _listed(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        value = getattr(option, field.name)
        if is_listed(field, value):
            yield field.name, value
