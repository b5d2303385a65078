"""The numbers that reports show of runs: recorded scalars and measures, by name."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from rl_design_space.learning.measures import ONLY_SCALARS, Measure, canonical, measure


def _name(spec: Any) -> str:
    """Return the name of a scalar, or the text form of a measure."""
    return str(spec) if spec in ONLY_SCALARS else canonical(spec)


#: Written as text or as a mapping, see `learning.measures.measure`; the field holds the text form.
ValueName = Annotated[str, BeforeValidator(_name, json_schema_input_type=str | dict[str, Any])]


def measure_of(name: str) -> Measure | None:
    """Return the measure of a name; None of a scalar that is no measure.

    Raises:
        ConfigError: there is no such scalar or measure.
    """
    return None if name in ONLY_SCALARS else measure(name)
