"""The shipped options, found from `conf/` and from the annotations of their classes."""

from __future__ import annotations

import math
import pkgutil
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import is_dataclass, replace
from itertools import product
from typing import Any

import yaml
from pydantic import ValidationError

from rl_design_space import design
from rl_design_space._paths import CONF
from rl_design_space.catalogue.fields import Schema, schemas_of

#: Every class that a design point is made of, and the point itself.
CLASSES = [kind for name in design.__all__ if is_dataclass(kind := getattr(design, name))]


def names_of(group: str) -> list[str]:
    """Return the options of a choice, by the names of their files."""
    return sorted(file.stem for file in CONF.glob(f"{group}/*.yaml"))


def overrides_of(group: str, name: str) -> list[str]:
    """Return the overrides that choose an option, with a representation that it needs."""
    overrides = [f"{group}={name}"]
    kind = pkgutil.resolve_name(yaml.safe_load((CONF / group / f"{name}.yaml").read_text(encoding="utf-8"))["_target_"])
    needed = {design.SeeingActions: "direct", design.Refine: "aggregated"}
    return [*overrides, *(f"representation={name}" for base, name in needed.items() if issubclass(kind, base))]


def variations(component: Any) -> Iterator[Any]:
    """Yield a component with every combination of named values, and with every number at a limit of its range."""
    alternatives = {name: _taken(schema) for name, schema in fields_of(type(component)).items()}
    named = {name: values for name, values in alternatives.items() if all(isinstance(each, str) for each in values)}
    changes = [dict(zip(named, chosen, strict=True)) for chosen in product(*named.values())]
    changes += [{name: value} for name in alternatives.keys() - named.keys() for value in alternatives[name]]
    for change in changes:
        with suppress(ValidationError):  # a class may refuse what does not go with its other fields
            yield replace(component, **change)


def refused(kind: type) -> Iterator[tuple[str, Any]]:
    """Yield values that a class refuses, each with the name of its field."""
    for name, schema in fields_of(kind).items():
        nothing = () if {"type": "null"} in schema.get("anyOf", ()) else (None,)
        for value in (object(), *nothing, *_outside(schema)):
            yield name, value


def fields_of(kind: type) -> dict[str, Schema]:
    """Return the JSON Schema of each field."""
    return schemas_of({"": kind}).classes[""]["properties"]


def _taken(schema: Schema) -> list[Any]:
    """Return all values of a field that has few, and otherwise the limits of its range."""
    if schema.get("type") == "boolean":
        return [False, True]
    limits = [schema[key] for key in ("minimum", "maximum") if key in schema]
    alternatives = [value for inner in schema.get("anyOf", ()) for value in _taken(inner)]
    return [*schema.get("enum", ()), *limits, *alternatives]


def _outside(schema: Schema) -> list[Any]:
    """Return values of the wrong type, and values beyond the limits of a range."""
    if "enum" in schema:
        return ["", "no_such_name", 1]
    if schema.get("type") not in ("integer", "number"):
        return []
    wrong, little = [math.nan, math.inf, -math.inf, "1", True], 0.01
    if schema["type"] == "integer":
        wrong, little = [*wrong, 1.0], 1
    beyond = {"minimum": -little, "maximum": little, "exclusiveMinimum": 0, "exclusiveMaximum": 0}
    return wrong + [schema[key] + more for key, more in beyond.items() if key in schema]
