"""What a class takes: its fields as JSON Schema, made by pydantic from their annotations."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

from pydantic import ConfigDict, PydanticUserError, TypeAdapter, create_model
from pydantic.errors import PydanticUndefinedAnnotation
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from rl_design_space.catalogue.docstrings import docstring_of

Schema = dict[str, Any]
_REFERENCE = "#/$defs/{model}"


class ClassSchemas(NamedTuple):
    """JSON Schemas of classes.

    Attributes:
        classes: one a class, by the name that was asked for, each with `properties`.
        definitions: what they refer to as `#/$defs/NAME`.
    """

    classes: Mapping[str, Schema]
    definitions: Mapping[str, Schema]


def schemas_of(kinds: Mapping[str, type]) -> ClassSchemas:
    """The fields of classes: their types, ranges and defaults; descriptions are those of the docstrings.

    A field of which pydantic cannot tell what it takes takes anything.
    """
    inputs: list[tuple[str, Any, TypeAdapter[Any]]] = [
        (name, "validation", _adapter(kind)) for name, kind in kinds.items()
    ]
    found, rest = TypeAdapter.json_schemas(inputs, ref_template=_REFERENCE, schema_generator=_Lenient)
    definitions = dict(rest.get("$defs", {}))
    classes = {}
    for (name, _), schema in found.items():
        described = dict(definitions[schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema)
        classes[name] = _described(described, kinds[name])
    return ClassSchemas(classes, definitions)


def _adapter(kind: type) -> TypeAdapter[Any]:
    """What pydantic makes of a class; of one that it cannot read, its fields without their types."""
    if is_dataclass(kind):
        try:
            return TypeAdapter(kind)
        except (PydanticUserError, PydanticUndefinedAnnotation, NameError, TypeError):
            names = [field.name for field in fields(kind)]
            return TypeAdapter(_model(kind, dict.fromkeys(names, (Any, None))))
    return TypeAdapter(_model(kind, _arguments(kind)))


def _arguments(kind: type) -> dict[str, tuple[Any, Any]]:
    """Type and default of what a class that is no dataclass is made with."""
    named = inspect.signature(kind, eval_str=True).parameters.values()
    given = [each for each in named if each.kind not in (each.VAR_POSITIONAL, each.VAR_KEYWORD)]
    return {
        each.name: (
            Any if each.annotation is each.empty else each.annotation,
            ... if each.default is each.empty else each.default,
        )
        for each in given
    }


def _model(kind: type, arguments: Mapping[str, tuple[Any, Any]]) -> Any:
    config = ConfigDict(extra="forbid", arbitrary_types_allowed=True, protected_namespaces=())
    return create_model(kind.__name__, __config__=config, **dict[str, Any](arguments))


def _described(schema: Schema, kind: type) -> Schema:
    """A class's schema in the words of its docstring."""
    said = docstring_of(kind)
    properties = {
        name: {**inner, **({"description": said.fields[name]} if name in said.fields else {})}
        for name, inner in schema.get("properties", {}).items()
    }
    described = {key: value for key, value in schema.items() if key != "description"}
    return {**described, **({"description": said.text} if said.text else {}), "properties": properties}


class _Lenient(GenerateJsonSchema):
    """Takes anything where only running a validator can tell what is right, and makes up no titles."""

    def handle_invalid_for_json_schema(self, schema: Any, error_info: str) -> JsonSchemaValue:
        return {}

    def function_before_schema(self, schema: core_schema.BeforeValidatorFunctionSchema) -> JsonSchemaValue:
        declared = schema.get("json_schema_input_schema")
        return self.generate_inner(declared) if declared is not None else {}

    def field_title_should_be_set(self, schema: Any) -> bool:
        return False

    def dataclass_schema(self, schema: core_schema.DataclassSchema) -> JsonSchemaValue:
        return {key: value for key, value in super().dataclass_schema(schema).items() if key != "title"}

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        return {key: value for key, value in super().model_schema(schema).items() if key != "title"}
