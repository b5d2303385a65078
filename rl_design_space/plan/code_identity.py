"""What stands for the code of a component in the identity of a point: its source, or the version that it declares.

Components of this package are known by their name, and what they do by `KERNEL_VERSION`.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

from rl_design_space.design.identity import full_name, is_shipped
from rl_design_space.errors import ConfigError
from rl_design_space.plan.source_files import code, modules_beside

#: Attribute of a class that is declared to stand in place of its source.
VERSION = "__version__"
#: Digits of a digest that people see.
_SHOWN = 12

#: Digests by the module's name; the spec tells whether the module is still the one that was digested.
_known: dict[str, tuple[ModuleSpec | None, str]] = {}


def source_of(kind: type) -> str:
    """What the code of a class is recognised by: `version 2` if it declares one, else `sha256:…` over its source.

    The source is that of the class's module and of those beside it that it imports, see `modules_beside`; without
    comments and blank lines.

    Raises:
        ConfigError: there is no source to be read, and no version.
    """
    version = vars(kind).get(VERSION)
    if version is None:
        return f"sha256:{_digest_of(kind)}"
    if isinstance(version, (str, int)) and not isinstance(version, bool):
        return f"version {version}"
    raise ConfigError(f"{full_name(kind)}.{VERSION}={version!r}: should be a text or a whole number")


def sources(component: Any, key: str) -> Iterator[tuple[str, str]]:
    """Of a component of the user's own: `KEY.source`, and what its code is recognised by, short enough for people."""
    if not is_dataclass(component) or isinstance(component, type):
        return
    if not is_shipped(type(component)):
        kind, colon, digest = source_of(type(component)).partition(":")
        yield f"{key}.source", kind + colon + digest[:_SHOWN]
    for field in fields(component):
        yield from sources(getattr(component, field.name), f"{key}.{field.name}")


def _digest_of(kind: type) -> str:
    """Read once for each import of the module: what is running is what was there then."""
    module = sys.modules.get(kind.__module__)
    spec, file = getattr(module, "__spec__", None), getattr(module, "__file__", None)
    known = _known.get(kind.__module__)
    if known is None or known[0] is not spec:
        if file is None or not file.endswith(".py") or not Path(file).is_file():
            raise ConfigError(
                f'{full_name(kind)}: has no source file to recognise it by; declare {VERSION} = "1" in the class, '
                "and another one whenever its results change"
            )
        known = _known[kind.__module__] = spec, _digest(kind.__module__, Path(file))
    return known[1]


def _digest(name: str, file: Path) -> str:
    """SHA-256 over the code of a module and of those that belong to it, each under its name."""
    total = hashlib.sha256()
    for module, path in sorted(modules_beside(name, file).items()):
        text = code(path).encode()
        total.update(f"{module} {len(text)}\n".encode() + text)
    return total.hexdigest()
