"""Build the design point of a recorded config, which anyone with write access to the store may have written.

Nothing in it is instantiated: Hydra would import and call whatever a `_target_` names, at any depth, and resolve
interpolations, which read the environment. Here, a `_target_` only selects among the classes of the package and those
that the config folder in use names for the same choice; see docs/security.md.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from typing import Any

from rl_design_space import design
from rl_design_space.config import user_config
from rl_design_space.config.build import construct, make_point
from rl_design_space.config.stage_options import CURRICULUM
from rl_design_space.config.target import check_fields, class_of, function_of
from rl_design_space.config.yaml_limits import load_plain, read_text
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError

_TARGET, _CARRY = "_target_", "carry"
#: The name of a class of this package, as configs write it or as runs of any version have recorded it.
_SHIPPED = re.compile(r"rl_design_space(?:\.design(?:\.[a-z_]+)?)?\.(?P<name>[A-Z]\w*)")


def recorded_point(config: Any, name: str) -> DesignPoint:
    """Build the point of a recorded config.

    Args:
        config: plain Python values.
        name: where it was recorded, for messages.

    Raises:
        ConfigError: it is not the config of a design point, names a class that is not among the expected ones, or has a
            value that is not allowed.
    """
    known = [field.name for field in fields(DesignPoint)]
    if not isinstance(config, Mapping) or not set(config) <= set(known):
        raise ConfigError(f"{name}: not the config of a design point, whose keys are {', '.join(known)}")
    try:
        return make_point({key: _value(key, key, node) for key, node in config.items()})
    except ConfigError as error:
        raise ConfigError(f"{name}: {error}") from error


def _value(choice: str, key: str, node: Any) -> Any:
    """Return the component that a node describes, or its plain value.

    Args:
        choice: the choice that the node belongs to.
        key: key of the node, for messages.
        node: plain Python values.
    """
    if isinstance(node, list):
        return tuple(_value(choice, key, item) for item in node)
    if not isinstance(node, Mapping):
        return node
    for name in node:
        if not isinstance(name, str) or (name.startswith("_") and name != _TARGET):
            raise ConfigError(f"{key}.{name}: no such key in a recorded config")
    kind = _expected_class(choice, f"{key}.{_TARGET}", node[_TARGET]) if _TARGET in node else None
    values = {
        name: _rule(choice, f"{key}.{name}", value) if name == _CARRY else _value(choice, f"{key}.{name}", value)
        for name, value in node.items()
        if name != _TARGET
    }
    if kind is None:
        return values
    check_fields(key, kind, node)
    try:
        return construct(kind, values, key)
    except ConfigError:
        raise
    except Exception as error:  # a user's own class may raise anything
        raise ConfigError(f"{key}: {error}".replace("\n", " ")) from error


def _rule(choice: str, key: str, name: Any) -> Any:
    """Return a carry rule; functions are imported only if the config folder in use names them."""
    if choice != CURRICULUM or not isinstance(name, str) or "." not in name:
        return name
    if name in _named(choice, _CARRY):
        return function_of(key, name)
    raise ConfigError.at(
        key,
        name,
        f"comes from the store, so it is not imported; {user_config.FLAG} FOLDER allows the functions that the files "
        f"in FOLDER/{choice} name",
    )


def _expected_class(choice: str, key: str, target: Any) -> Any:
    """Return the class that a recorded `_target_` names; only names from the config folder in use are imported."""
    found = _SHIPPED.fullmatch(target) if isinstance(target, str) else None
    if found and is_dataclass(kind := getattr(design, found["name"], None)):
        return kind
    for named in {*_named(choice, _TARGET)}:
        with suppress(ConfigError):  # an option that cannot be used
            kind = class_of(choice, named)
            if target in (named, f"{kind.__module__}.{kind.__qualname__}"):
                return kind
    raise ConfigError.at(
        key,
        target,
        f"comes from the store, so it is not imported; {user_config.FLAG} FOLDER allows the classes that the files in "
        f"FOLDER/{choice} name",
    )


def _named(choice: str, key: str) -> Iterator[str]:
    """Yield what the user's config folder names for a choice under a key; stages may name options of all choices."""
    if folder := user_config.user_folder():
        within = [folder / field.name for field in fields(DesignPoint)] if choice == CURRICULUM else [folder / choice]
        for path in sorted(path for each in within for path in each.rglob("*.yaml")):
            with suppress(ConfigError, OSError, UnicodeError):  # a file that cannot be used
                yield from _texts_in(load_plain(read_text(path), str(path)), key)


def _texts_in(node: Any, key: str) -> Iterator[str]:
    if isinstance(node, list):
        for item in node:
            yield from _texts_in(item, key)
    elif isinstance(node, Mapping):
        for name, value in node.items():
            if name == key and isinstance(value, str):
                yield value
            else:
                yield from _texts_in(value, key)
