"""What an option is known by, and fields that it gets later in its life."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

#: Key of a field's metadata.
ABSENT_AS = "absent_as"


def absent_as(value: Any) -> Mapping[str, Any]:
    """Metadata of a field that is added to an option when points of the option have been recorded already.

    A point in which the field has this value has the fingerprint that it had before there was the field, so what was
    recorded stays valid:

        slip: float = field(default=0.0, metadata=absent_as(0.0))

    The value is the one with which results are as before. It stays, even if the default changes later.
    """
    return {ABSENT_AS: value}


def is_shipped(kind: type) -> bool:
    """Whether a class is part of this package."""
    return kind.__module__.startswith("rl_design_space.")


def full_name(kind: type) -> str:
    """The name of a class for people: of this package's the plain one, of others with their module."""
    return kind.__qualname__ if is_shipped(kind) else f"{kind.__module__}.{kind.__qualname__}"
