"""Fields of classes, from annotations and docstrings, and their types and ranges in words."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Literal

import pytest
from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter
from pydantic.dataclasses import dataclass

from rl_design_space.catalogue.docstrings import docstring_of
from rl_design_space.catalogue.fields import schemas_of
from rl_design_space.catalogue.wording import kind_in_words, range_in_words


class Foreign:
    """No type that pydantic knows."""


@dataclasses.dataclass(frozen=True)
class Base:
    """What both share.

    Attributes:
        shared: of the base.
    """

    shared: int = 1


@dataclasses.dataclass(frozen=True)
class Derived(Base):
    """A class of one's own: with details.

    More text.

    Attributes:
        one: the first,
            in two lines.
        two, three: both of these (e.g. x: y).

    Raises:
        ValueError: never.
    """

    one: Annotated[float, Field(ge=0)] = 0.5
    two: Literal["a", "b"] = "a"
    three: Any = None


@dataclasses.dataclass(frozen=True)
class Bare:
    other: Foreign | None = None
    number: int = 3


@dataclass(frozen=True)
class Validated:
    """Validated."""

    opaque: Annotated[int, BeforeValidator(int)] = 0
    checked: Annotated[int, AfterValidator(abs)] = 0


class Plugin:
    """A plugin.

    Args:
        address: where.
    """

    def __init__(self, address: str | None = None, *rest: int, chunk: int = 5, loose=None) -> None:
        pass


def test_a_docstring_is_split_into_its_parts():
    docstring = docstring_of(Derived)
    assert docstring.summary == "A class of one's own: with details"
    assert docstring.text == "A class of one's own: with details.\n\nMore text."
    assert docstring.fields == {
        "shared": "of the base.",
        "one": "the first, in two lines.",
        "two": "both of these (e.g. x: y).",
        "three": "both of these (e.g. x: y).",
    }


def test_the_signature_that_dataclasses_get_is_not_a_docstring():
    assert Bare.__doc__.startswith("Bare(")
    assert docstring_of(Bare) == ("", "", {})


def test_fields_have_type_range_default_and_description():
    schema = schemas_of({"x": Derived}).classes["x"]
    assert schema["description"] == "A class of one's own: with details.\n\nMore text."
    assert schema["properties"]["one"] == {
        "type": "number",
        "minimum": 0,
        "default": 0.5,
        "description": "the first, in two lines.",
    }
    assert list(schema["properties"]) == ["shared", "one", "two", "three"]


def test_a_class_that_pydantic_cannot_read_has_fields_without_types():
    assert list(schemas_of({"x": Bare}).classes["x"]["properties"]) == ["other", "number"]


def test_a_field_that_only_a_validator_can_check_accepts_anything():
    properties = schemas_of({"x": Validated}).classes["x"]["properties"]
    assert properties["opaque"] == {"default": 0}
    assert properties["checked"] == {"default": 0, "type": "integer"}


def test_the_fields_of_a_plugin_are_its_arguments():
    properties = schemas_of({"x": Plugin}).classes["x"]["properties"]
    assert list(properties) == ["address", "chunk", "loose"]
    assert properties["address"]["description"] == "where."
    assert properties["chunk"] == {"type": "integer", "default": 5}
    assert properties["loose"] == {"default": None}


@pytest.mark.parametrize(
    ("annotation", "kind", "values"),
    [
        (int, "whole number", ""),
        (Annotated[int, Field(ge=1, lt=10)], "whole number", "1 to 9"),
        (Annotated[int, Field(gt=1)], "whole number", "at least 2"),
        (Annotated[float, Field(gt=0)], "number", "above 0"),
        (Annotated[float, Field(gt=0, le=1)], "number", "above 0, at most 1"),
        (Annotated[float, Field(ge=0, le=1)], "number", "0 to 1"),
        (Annotated[float, Field(lt=0)], "number", "below 0"),
        (Annotated[int, Field(ge=1)] | None, "whole number or null", "at least 1"),
        (Literal["a", "b"], "one of", "a, b"),
        (Literal["a"], "one of", "a"),
        (Annotated[str, Field(min_length=1)], "text", "not empty"),
        (bool, "true or false", ""),
        (list[Annotated[int, Field(ge=2)]], "list of whole numbers", "at least 2"),
        (tuple[int, int], "list of 2 whole numbers", ""),
        (int | tuple[int, int], "whole number or list of 2 whole numbers", ""),
        (dict[str, int], "mapping", ""),
        (list[Any], "list", ""),
        (Any, "any", ""),
    ],
)
def test_types_and_ranges_in_words(annotation: Any, kind: str, values: str):
    schema = TypeAdapter(annotation).json_schema()
    assert (kind_in_words(schema), range_in_words(schema)) == (kind, values)
