"""Types and ranges of JSON Schema in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rl_design_space._yaml import as_yaml

_KINDS = {
    "integer": "whole number",
    "number": "number",
    "string": "text",
    "boolean": "true or false",
    "null": "null",
    "object": "mapping",
    "array": "list",
}
_PLURALS = {"whole number": "whole numbers", "number": "numbers", "text": "texts", "list": "lists"}


def kind_in_words(schema: Mapping[str, Any]) -> str:
    """Return the type of a value in words: `number`, `list of whole numbers`, `text or null`."""
    if alternatives := _alternatives(schema):
        return " or ".join(dict.fromkeys(map(kind_in_words, alternatives)))
    if "enum" in schema or "const" in schema:
        return "one of"
    if "$ref" in schema:
        return str(schema["$ref"]).rpartition("/")[2]
    if schema.get("type") == "array" and (items := _items(schema)):
        inner = kind_in_words(items)
        count = f"{schema['maxItems']} " if schema.get("minItems") == schema.get("maxItems", -1) else ""
        return f"list of {count}{_PLURALS.get(inner, inner)}"
    return _KINDS.get(str(schema.get("type")), "any")


def range_in_words(schema: Mapping[str, Any]) -> str:
    """Return the range of a value in words: `0 to 1`, `at least 2`, `above 0`, `first, random`; empty if unlimited."""
    if alternatives := _alternatives(schema):
        return "; ".join(dict.fromkeys(filter(None, map(range_in_words, alternatives))))
    if "const" in schema:
        return as_yaml(schema["const"])
    if "enum" in schema:
        return ", ".join(map(as_yaml, schema["enum"]))
    if schema.get("type") == "array" and (items := _items(schema)):
        return range_in_words(items)
    return _bounds(schema) or ("not empty" if schema.get("minLength") else str(schema.get("pattern", "")))


def _alternatives(schema: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [*schema.get("anyOf", ()), *schema.get("oneOf", ())]


def _items(schema: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the schema of the items of a list; of a tuple, that of the first item."""
    found = schema.get("items") or next(iter(schema.get("prefixItems", ())), None)
    return found if isinstance(found, Mapping) else None


def _bounds(schema: Mapping[str, Any]) -> str:
    low, high = schema.get("minimum"), schema.get("maximum")
    above, below = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
    if schema.get("type") == "integer":  # the nearest allowed whole numbers
        low = above + 1 if above is not None else low
        high = below - 1 if below is not None else high
        above = below = None
    if low is not None and high is not None:
        return f"{low} to {high}"
    named = {"at least": low, "above": above, "at most": high, "below": below}
    return ", ".join(f"{word} {bound}" for word, bound in named.items() if bound is not None)
