"""The JSON Schemas of config files: a component by its `_target_`, a study, the primary config."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import ClassSchemas, Schema
from rl_design_space.catalogue.openness import FILLED_IN, opened, opened_fields

#: The dialect that most editors support.
_DIALECT = "http://json-schema.org/draft-07/schema#"
#: A class of another package.
_OWN_TARGET = r"^(?!(hydra_plugins\.)?rl_design_space\.)[A-Za-z_]\w*([.:][A-Za-z_]\w*)+$"
_CHANGES = {"$ref": "#/$defs/changes"}
_DEFAULTS = {"description": "Hydra's defaults list: the files that this one extends", "type": "array"}


def document(title: str, description: str, content: Schema, definitions: Mapping[str, Schema]) -> Schema:
    """Return the content of a schema file.

    Args:
        title: name of the described files.
        description: description of these files.
        content: schema of these files.
        definitions: schemas that the content may refer to, before `opened_fields`.
    """
    candidates = FILLED_IN | {name: opened_fields(_without_title(schema)) for name, schema in definitions.items()}
    defined: dict[str, Schema] = {}
    while missing := _referred_to([content, defined]) - set(defined):
        defined |= {name: candidates[name] for name in sorted(missing)}
    return {"$schema": _DIALECT, "title": title, "description": description, **content, "$defs": defined}


def _referred_to(content: Any) -> set[str]:
    """Return the names of the definitions that a schema refers to."""
    return set(re.findall(r'"\$ref": "#/\$defs/([^"]+)"', json.dumps(content)))


def component(kinds: Mapping[str, type], schemas: ClassSchemas, inherited: bool = True) -> Schema:
    """Return the schema of a component: the fields of one of these classes, or of a user's own class.

    Args:
        kinds: the known classes, by `_target_`.
        schemas: their schemas.
        inherited: whether `_target_` may come from the files in the defaults list.
    """
    targets = [{"const": path, "description": docstring_of(kind).summary} for path, kind in kinds.items()]
    modules = sorted({_full_name(kind) for kind in kinds.values()} - {*kinds})
    same = [{"description": "the same class, by its module", "enum": modules}] if modules else []
    own = {"description": "a class of your own", "type": "string", "pattern": _OWN_TARGET}
    named = {"description": "the class of this option", "anyOf": [*targets, *same, own, {"$ref": "#/$defs/filled_in"}]}
    needed: Schema = {"required": ["_target_"]}
    return {
        "type": "object",
        "properties": {"_target_": named, **({"defaults": _DEFAULTS} if inherited else {})},
        "allOf": [
            _unless_inherited(needed) if inherited else needed,
            *(_fields_of(path, kind, schemas.classes[path], inherited) for path, kind in kinds.items()),
        ],
    }


def changed(schema: Schema) -> Schema:
    """Return the schema of a component whose class is known, with any of its fields."""
    fields = opened_fields(_without_title(schema))
    return {**fields, "properties": {"_target_": {}, **fields["properties"]}, "required": []}


def study(
    report: Schema, constraint: Schema, variations: Schema, keys: Mapping[str, Schema], tops: Iterable[str]
) -> Schema:
    """Return the schema of a study.

    Args:
        report: schema of its report.
        constraint: schema of one of its constraints.
        variations: schema of its variations; what readings change is `#/$defs/changes`, see `changes`.
        keys: schema of a single value, by key of design points.
        tops: first parts of keys, so that keys of the user's own components are allowed.
    """
    block = {
        "description": "a grid: all combinations of these lists, or text in Hydra's sweep grammar, as in 10,20,30",
        "type": "object",
        "properties": {key: _sweep(schema) for key, schema in keys.items()},
        "patternProperties": {_key_pattern(tops): {}},
        "additionalProperties": False,
    }
    fields = opened_fields(_without_title(variations))
    needed = {"variations": {"required": fields.pop("required", [])}, "report": {"allOf": _needed(report["allOf"])}}
    checked = {**report, "allOf": [_lenient(rule) for rule in report["allOf"] if "if" in rule]}
    for name, values in (("readings", {"additionalProperties": _CHANGES}), ("values", _CHANGES)):
        words = {"description": fields["properties"][name]["description"]}
        fields["properties"][name] = {"type": "object", **values, **words}
    return {
        "type": "object",
        "properties": {
            "defaults": _DEFAULTS,
            "blocks": {
                "description": "the grids that make up the study, by a name of your choice",
                "type": "object",
                "additionalProperties": block,
            },
            "constraints": {
                "description": "combinations that are excluded, by a name of your choice",
                "type": ["object", "null"],
                "additionalProperties": opened_fields(constraint),
            },
            "includes": {
                "description": "other studies whose points belong to this one, instead of blocks",
                "type": "array",
                "items": {"type": "string"},
            },
            "variations": {"description": "readings that change these points, alone and combined", **fields},
            "report": {"description": "the report that rl-design-report writes", **checked},
        },
        "additionalProperties": False,
        **_unless_inherited({"properties": needed}),
        "anyOf": [{"required": [key]} for key in ("blocks", "includes", "report", "defaults")],
    }


def _needed(rules: Iterable[Schema]) -> list[Schema]:
    """Return what the rules of a component require, without what they check."""
    return [
        {"if": rule["if"], "then": {"required": rule["then"].get("required", [])}} if "if" in rule else rule
        for rule in rules
    ]


def _lenient(rule: Schema) -> Schema:
    """Return a rule of a component without what it requires."""
    return {**rule, "then": {key: value for key, value in rule["then"].items() if key != "required"}}


def changes(keys: Mapping[str, Schema], tops: Iterable[str]) -> Schema:
    """Return the schema of values by key, without sweeps; the arguments are those of `study`."""
    patterns: Schema = {_key_pattern(tops): {}}
    return {"type": "object", "properties": dict(keys), "patternProperties": patterns, "additionalProperties": False}


def _key_pattern(tops: Iterable[str]) -> str:
    return rf"^[+~]*({'|'.join(tops)})([./@].*)?$"


def primary(keys: Mapping[str, Schema], groups: Mapping[str, str]) -> Schema:
    """Return the schema of a whole configuration: the primary config, or a file with `# @package _global_`.

    Args:
        keys: schemas of the keys that are not choices.
        groups: descriptions of the choices.
    """
    chosen = {name: {"description": text, "type": ["object", "null"]} for name, text in groups.items()}
    hydra = {"description": "settings of Hydra", "type": "object"}
    return {
        "type": "object",
        "properties": {"defaults": _DEFAULTS, **chosen, **keys, "hydra": hydra},
        "additionalProperties": False,
    }


def _fields_of(path: str, kind: type, schema: Schema, inherited: bool) -> Schema:
    """Return the rule that a file which names a class has only fields of this class."""
    given: Schema = {"_target_": {}, **({"defaults": {}} if inherited else {})}
    checked = opened_fields(_without_title(schema))
    checked["properties"] = given | checked["properties"]
    if required := checked.pop("required", None):
        needed: Schema = {"required": required}
        checked |= _unless_inherited(needed) if inherited else needed
    names = sorted({path, _full_name(kind)})
    return {"if": {"required": ["_target_"], "properties": {"_target_": {"enum": names}}}, "then": checked}


def _full_name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _unless_inherited(needed: Schema) -> Schema:
    return {"if": {"not": {"required": ["defaults"]}}, "then": needed}


def _sweep(schema: Schema) -> Schema:
    """Return the schema of a single value, of text that lists several, or of a list of them."""
    single = opened(schema)
    words = {"description": single["description"]} if "description" in single else {}
    checks: dict[str, Any] = {key: value for key, value in single.items() if key not in ("description", "default")}
    if not checks:
        return words
    alternatives = checks["anyOf"] if set(checks) == {"anyOf"} else [checks]
    several = [
        {"description": "a sweep, as in 10,20,30", "type": "string"},
        {
            "description": "a sweep over these values",
            "type": "array",
            "items": {"anyOf": [*alternatives, {"type": "string"}]},
        },
    ]
    return words | {"anyOf": [*alternatives, *several]}


def _without_title(schema: Schema) -> Schema:
    return {key: value for key, value in schema.items() if key != "title"}
