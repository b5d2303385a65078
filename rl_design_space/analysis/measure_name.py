"""The type of fields that name a measure: its text form, validated."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from rl_design_space.learning.measures import canonical

#: Written as text or as a mapping, see `learning.measures.measure`; the field holds the text form.
MeasureName = Annotated[str, BeforeValidator(canonical, json_schema_input_type=str | dict[str, Any])]
