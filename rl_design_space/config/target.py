"""Import the class that a `_target_` names, with error messages for names and modules."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from pkgutil import resolve_name
from traceback import extract_tb
from types import FunctionType
from typing import Any

from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError


def imported(key: str, target: object) -> type:
    """Import the class that a `_target_` names.

    Args:
        key: where the target is written, e.g. `world._target_`.
        target: module and class, e.g. `mine.Ring`.

    Raises:
        ConfigError: it cannot be imported, or is not a class.
    """
    if not isinstance(target, str):
        raise ConfigError.at(key, target, "should name a class, as in module.Class")
    kind = _resolved(key, target)
    if not isinstance(kind, type):
        raise ConfigError.at(key, target, "should name a class, as in module.Class")
    return kind


def function_of(key: str, name: str) -> FunctionType:
    """Import the function that a value names.

    Args:
        key: where the name is written, e.g. `curriculum.carry`.
        name: module and function, e.g. `mine.nearest`.

    Raises:
        ConfigError: it cannot be imported, or is not a function.
    """
    function = _resolved(key, name)
    if not isinstance(function, FunctionType):
        raise ConfigError.at(key, name, "should name a function, as in module.function")
    return function


def _resolved(key: str, name: str) -> Any:
    try:
        return resolve_name(name)
    except Exception as error:  # a module may raise anything when it is imported
        raise ConfigError.at(key, name, f"cannot be imported: {_reason(name, error)}") from error


def class_of(key: str, target: object) -> Any:
    """Import the dataclass that an option names.

    Args:
        key: key of the option, e.g. `world`.
        target: module and class, e.g. `mine.Ring`.

    Raises:
        ConfigError: it cannot be imported, or is not a dataclass.
    """
    kind = imported(f"{key}._target_", target)
    if not is_dataclass(kind):
        raise ConfigError.at(f"{key}._target_", target, "should be a frozen dataclass")
    return kind


def check_fields(key: str, kind: Any, node: Mapping[str, Any]) -> None:
    """Refuse keys without a field, and fields without a value.

    Raises:
        ConfigError: the class has no field of this name, or a field needs a value.
    """
    known = {field.name: field for field in fields(kind) if field.init}
    for name in node:
        if name not in known and not str(name).startswith("_"):
            raise ConfigError.unknown("key", str(name), known, f"{key}.")
    for name, field in known.items():
        if name not in node and field.default is MISSING and field.default_factory is MISSING:
            raise ConfigError.at(f"{key}.{name}", "???", f"needs a value; {kind.__name__} has no default for it")


def _reason(target: str, error: Exception) -> str:
    """Return why a target cannot be imported."""
    if isinstance(error, ModuleNotFoundError):
        return _not_found(target, error)
    if isinstance(error, AttributeError):
        return _no_such_name(target, error)
    if isinstance(error, SyntaxError):
        return f"{error.filename}:{error.lineno}: {error.msg}"
    place = extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"


def _not_found(target: str, error: ModuleNotFoundError) -> str:
    """Explain which module is missing: the target's, with the places searched, or one that it imports."""
    module = target.partition(":")[0].partition(".")[0]
    if error.name != module:
        place = extract_tb(error.__traceback__)[-1]
        importing = (
            ""
            if "importlib" in place.filename or "pkgutil" in place.filename
            else f" ({place.filename}:{place.lineno})"
        )
        return f"{error}{importing}"
    folders = ", ".join(user_config.module_folders())
    return f"{error}; looked in {folders} and the installed packages"


def _no_such_name(target: str, error: AttributeError) -> str:
    """Explain which classes a module has instead, and its file: it may not be the intended module."""
    modules = [name for name in sys.modules if target.startswith(f"{name}.")]
    module = sys.modules.get(max(modules, key=len, default=""))
    if module is None or error.obj is not module:
        return str(error)
    known = [
        name for name, value in vars(module).items() if is_dataclass(value) and value.__module__ == module.__name__
    ]
    missing = str(ConfigError.unknown("class", str(error.name), known))
    return (
        f"{getattr(module, '__file__', None) or module.__name__} has no '{error.name}': {missing}"
        if known
        else str(error)
    )
