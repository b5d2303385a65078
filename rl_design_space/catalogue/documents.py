"""The JSON Schemas of config files: a component by its `_target_`, a study, the primary config."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import ClassSchemas, Schema
from rl_design_space.catalogue.openness import FILLED_IN, opened, opened_fields

#: What editors know best.
_DIALECT = "http://json-schema.org/draft-07/schema#"
#: A class that is not of this project.
_OWN_TARGET = r"^(?!(hydra_plugins\.)?rl_design_space\.)[A-Za-z_]\w*([.:][A-Za-z_]\w*)+$"
_DEFAULTS = {"description": "Hydra's defaults list: the files that this one builds on", "type": "array"}


def document(title: str, description: str, content: Schema, definitions: Mapping[str, Schema]) -> Schema:
    """A whole schema file.

    Args:
        title: of what it is for.
        description: of that.
        content: what is checked.
        definitions: that the content may refer to, before they are opened.
    """
    candidates = FILLED_IN | {name: opened_fields(_without_title(schema)) for name, schema in definitions.items()}
    defined: dict[str, Schema] = {}
    while missing := _referred_to([content, defined]) - set(defined):
        defined |= {name: candidates[name] for name in sorted(missing)}
    return {"$schema": _DIALECT, "title": title, "description": description, **content, "$defs": defined}


def _referred_to(content: Any) -> set[str]:
    """The definitions that something refers to."""
    return set(re.findall(r'"\$ref": "#/\$defs/([^"]+)"', json.dumps(content)))


def component(kinds: Mapping[str, type], schemas: ClassSchemas, inherited: bool = True) -> Schema:
    """What describes a component: the fields of one of these classes, or of a class of the user's own.

    Args:
        kinds: the classes that may be named, by `_target_`.
        schemas: theirs.
        inherited: whether a file may leave `_target_` to the files that its defaults list names.
    """
    targets = [{"const": path, "description": docstring_of(kind).summary} for path, kind in kinds.items()]
    modules = sorted({_full_name(kind) for kind in kinds.values()} - {*kinds})
    same = [{"description": "the same, by its module", "enum": modules}] if modules else []
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
    """What describes values of a component whose class is settled; they may be a part of its fields."""
    fields = opened_fields(_without_title(schema))
    return {**fields, "properties": {"_target_": {}, **fields["properties"]}, "required": []}


def study(report: Schema, constraint: Schema, keys: Mapping[str, Schema], tops: Iterable[str]) -> Schema:
    """What describes a study.

    Args:
        report: what describes its report.
        constraint: what describes one of its constraints.
        keys: of design points and their values, each with what a single value of it is like.
        tops: what keys may begin with, such as those of the user's own components.
    """
    block = {
        "description": "a grid: all combinations of these sweeps; text is Hydra's sweep grammar, as in 10,20,30",
        "type": "object",
        "properties": {key: _sweep(schema) for key, schema in keys.items()},
        "patternProperties": {rf"^[+~]*({'|'.join(tops)})([./@].*)?$": {}},
        "additionalProperties": False,
    }
    return {
        "type": "object",
        "properties": {
            "defaults": _DEFAULTS,
            "blocks": {
                "description": "the grids whose points are the study's, by a name of your choice",
                "type": "object",
                "additionalProperties": block,
            },
            "constraints": {
                "description": "combinations that are left out, by a name of your choice",
                "type": ["object", "null"],
                "additionalProperties": opened_fields(constraint),
            },
            "includes": {
                "description": "instead of blocks: other studies, whose points are this one's as well",
                "type": "array",
                "items": {"type": "string"},
            },
            "report": {"description": "what rl-design-report writes of it", **report},
        },
        "additionalProperties": False,
        "anyOf": [{"required": [key]} for key in ("blocks", "includes", "report", "defaults")],
    }


def primary(keys: Mapping[str, Schema], groups: Mapping[str, str]) -> Schema:
    """What describes a whole configuration: the primary config, or a file with `# @package _global_`.

    Args:
        keys: the keys that are no choices, each with what it holds.
        groups: the choices, each with what is chosen.
    """
    chosen = {name: {"description": said, "type": ["object", "null"]} for name, said in groups.items()}
    hydra = {"description": "Hydra's own", "type": "object"}
    return {
        "type": "object",
        "properties": {"defaults": _DEFAULTS, **chosen, **keys, "hydra": hydra},
        "additionalProperties": False,
    }


def _fields_of(path: str, kind: type, schema: Schema, inherited: bool) -> Schema:
    """If a class is named, its fields are what there may be."""
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
    """A single value, or text that lists several."""
    single = opened(schema)
    words = {"description": single["description"]} if "description" in single else {}
    checks: dict[str, Any] = {key: value for key, value in single.items() if key not in ("description", "default")}
    if not checks:
        return words
    alternatives = checks["anyOf"] if set(checks) == {"anyOf"} else [checks]
    return words | {"anyOf": [*alternatives, {"description": "a sweep, as in 10,20,30", "type": "string"}]}


def _without_title(schema: Schema) -> Schema:
    return {key: value for key, value in schema.items() if key != "title"}
