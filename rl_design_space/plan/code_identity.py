"""What stands for the code of a component in the identity of a point: its source, or a version that it declares.

Components of this package are identified by their name, and `KERNEL_VERSION` stands for their code.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import FunctionType
from typing import Any

from rl_design_space.config.own_modules import source_of
from rl_design_space.design import Stage
from rl_design_space.design.identity import full_name, function_name, is_shipped
from rl_design_space.errors import ConfigError
from rl_design_space.plan.source_files import code, modules_beside

#: Class attribute that declares a version, which then stands for the source.
VERSION = "__version__"
#: Digits of a digest that `source_parameters` keeps.
_SHOWN_DIGITS = 12


def code_identity(kind: type | FunctionType) -> str:
    """Return the identity of the code of a class or function: `version 2` if it declares one, else `sha256:…`.

    The latter is a digest of the source of its module and of the modules that it imports from the same folder, see
    `modules_beside`, without comments and blank lines.

    Raises:
        ConfigError: it has no readable source and declares no version, the version is not allowed, Python has imported
            it from an outdated bytecode file, or a function has no name in its module.
    """
    if isinstance(kind, FunctionType) and "<" in kind.__qualname__:
        raise ConfigError(f"{function_name(kind)}: should be a function of a module, which its name identifies")
    version = vars(kind).get(VERSION)
    if version is None:
        return f"sha256:{_source_digest(kind)}"
    if isinstance(version, (str, int)) and not isinstance(version, bool):
        return f"version {version}"
    raise ConfigError(f"{full_name(kind)}.{VERSION}={version!r}: should be a string or a whole number")


def source_parameters(component: Any, key: str) -> Iterator[tuple[str, str]]:
    """Yield `KEY.source` and a shortened code identity for each user component in a component, itself included."""
    if isinstance(component, tuple):
        for number, part in enumerate(component, 1):
            yield from source_parameters(part, f"{key}.{number}")
        return
    if isinstance(component, Stage):
        for name, value in component.changes:
            yield from source_parameters(value, f"{key}.{name}")
        yield from source_parameters(component.carry, f"{key}.carry")
        return
    if isinstance(component, FunctionType):
        yield f"{key}.source", _shown(component)
    if not is_dataclass(component) or isinstance(component, type):
        return
    if not is_shipped(type(component)):
        yield f"{key}.source", _shown(type(component))
    for field in fields(component):
        yield from source_parameters(getattr(component, field.name), f"{key}.{field.name}")


def _shown(kind: type | FunctionType) -> str:
    kind_of, colon, digest = code_identity(kind).partition(":")
    return kind_of + colon + digest[:_SHOWN_DIGITS]


def _source_digest(kind: type | FunctionType) -> str:
    module = sys.modules.get(kind.__module__)
    file = getattr(module, "__file__", None)
    try:
        return _digest(kind.__module__, _Import(getattr(module, "__spec__", None)), file)
    except FileNotFoundError as error:
        raise ConfigError(
            f'{full_name(kind)}: has no source file to recognise it by; declare {VERSION} = "1" in the class, and '
            "change it whenever its results change"
        ) from error


class _Import:
    """One import of a module, as a cache key: reloading a module gives it a new spec."""

    def __init__(self, spec: ModuleSpec | None) -> None:
        self._spec = spec

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Import) and self._spec is other._spec

    def __hash__(self) -> int:
        return id(self._spec)


@cache
def _digest(name: str, imported: _Import, file: str | None) -> str:
    """Return SHA-256 over the code of a module and of the modules that belong to it, each under its name.

    The source is that which was imported: later changes of a file do not affect the code that is running.

    Args:
        name: of the module.
        imported: the import that loaded it.
        file: its source.

    Raises:
        FileNotFoundError: there is no source file.
    """
    if file is None or not file.endswith(".py") or not Path(file).is_file():
        raise FileNotFoundError(file)
    total = hashlib.sha256()
    for module, path in sorted(modules_beside(name, Path(file)).items()):
        text = code(source_of(module, path)).encode()
        total.update(f"{module} {len(text)}\n".encode() + text)
    return total.hexdigest()
