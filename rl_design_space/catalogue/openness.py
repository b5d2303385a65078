"""JSON Schemas that also accept what Hydra fills in later: `???` and interpolations."""

from __future__ import annotations

from typing import Any

from rl_design_space.catalogue.fields import Schema

#: The definition that opened schemas refer to.
FILLED_IN = {"filled_in": {"description": "filled in by Hydra", "type": "string", "pattern": r"^\?\?\?$|\$\{.+\}"}}
_REFERENCE = {"$ref": "#/$defs/filled_in"}
_WORDS = ("description", "default")


def opened(schema: Schema) -> Schema:
    """Return the schema for YAML files: each value may also be `???` or an interpolation `${…}`."""
    words = {key: schema[key] for key in _WORDS if key in schema}
    checks = _with_opened_parts({key: value for key, value in schema.items() if key not in _WORDS})
    if not checks or checks == {"type": "string"}:
        return words | checks
    alternatives = checks["anyOf"] if set(checks) == {"anyOf"} else [checks]
    return words | {"anyOf": [*alternatives, _REFERENCE]}


def opened_fields(schema: Schema) -> Schema:
    """Return the schema of an object in which each field, but not the object itself, may be filled in later."""
    return _with_opened_parts(schema)


def _with_opened_parts(schema: Schema) -> Schema:
    found: dict[str, Any] = dict(schema)
    if "prefixItems" in found:  # its name in the dialect that editors support
        found["items"] = found.pop("prefixItems")
    for key in ("items", "additionalProperties"):
        if isinstance(found.get(key), list):
            found[key] = [opened(inner) for inner in found[key]]
        elif isinstance(found.get(key), dict):
            found[key] = opened(found[key])
    for key in ("anyOf", "oneOf", "allOf"):
        if key in found:
            found[key] = [_with_opened_parts(inner) for inner in found[key]]
    for key in ("properties", "patternProperties"):
        if key in found:
            found[key] = {name: opened(inner) for name, inner in found[key].items()}
    return found
