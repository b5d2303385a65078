"""Names of components, and fields that are added to a component after it has been recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field
from types import FunctionType
from typing import Any

#: Keys in the metadata of a field.
ABSENT_AS, LISTED = "absent_as", "listed"


def absent_as(value: Any, *, listed: bool = True) -> Mapping[str, Any]:
    """Return the metadata of a field that is added to a component of which points have been recorded.

    A point in which the field has this value keeps the fingerprint that it had without the field, so recorded results
    stay valid:

        slip: float = field(default=0.0, metadata=absent_as(0.0))

    Args:
        value: the value that leaves results unchanged. It must not be changed later, even if the default is.
        listed: whether the parameters and the config of a point show the field while it has this value.
    """
    return {ABSENT_AS: value, LISTED: listed}


def is_listed(field: Field[Any], value: Any) -> bool:
    """Return whether the parameters and the config of a point show a field that has a value."""
    return bool(field.metadata.get(LISTED, True)) or value != field.metadata[ABSENT_AS]


def is_shipped(kind: type | FunctionType) -> bool:
    """Return whether a class or function is part of this package."""
    return is_shipped_name(kind.__module__)


def is_shipped_name(name: str) -> bool:
    """Return whether a module, or what a dotted name stands for, is part of this package."""
    return name.startswith("rl_design_space.")


def full_name(kind: type | FunctionType) -> str:
    """Return the name of a class for messages; classes of other packages are named with their module."""
    return kind.__qualname__ if is_shipped(kind) else f"{kind.__module__}.{kind.__qualname__}"


def function_name(function: Any) -> str:
    """Return module and name of a function, as it is written in configs."""
    return f"{function.__module__}.{function.__qualname__}"
