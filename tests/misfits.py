"""Components that break their contract, made from built-in ones."""

from __future__ import annotations

from dataclasses import fields
from typing import Any


def misfit(component: Any, **members: object) -> Any:
    """Return a component that differs from the given one in these members."""
    values = {field.name: getattr(component, field.name) for field in fields(component)}
    return type("Misfit", (type(component),), members)(**values)
