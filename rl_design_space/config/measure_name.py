"""Names of measures in configs and on the command line: text, mappings, and functions of the user's own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator

from rl_design_space.learning.measures import ONLY_SCALARS, Measure, canonical, measure

#: Keys of reports and settings whose values name measures.
_KEYS = ("measure", "measures", "value", "values", "leaderboard", "objective")


def _value_name(spec: Any) -> str:
    """Return the name of a scalar, or the text form of a measure."""
    return spec if isinstance(spec, str) and spec in ONLY_SCALARS else canonical(spec)


#: A field that names a measure: written as text or as a mapping, see `learning.measures.measure`; held as text.
MeasureName = Annotated[str, BeforeValidator(canonical, json_schema_input_type=str | dict[str, Any])]
#: A field that names a measure or another recorded scalar.
ValueName = Annotated[str, BeforeValidator(_value_name, json_schema_input_type=str | dict[str, Any])]


def measure_of(name: str) -> Measure | None:
    """Return the measure of a name; None of a scalar that is no measure.

    Raises:
        ConfigError: there is no such scalar or measure.
    """
    return None if name in ONLY_SCALARS else measure(name)


def with_own_measures(node: Any) -> Any:
    """Return a node of a config in which own measures are named by text: `{_target_: mine.late}` becomes `mine.late`.

    Everything else with a `_target_` is built by Hydra, which would call the function.

    Raises:
        ConfigError: a parameter of such a measure is not allowed.
    """
    if isinstance(node, Mapping):
        return {key: _named(value) if key in _KEYS else with_own_measures(value) for key, value in node.items()}
    return [with_own_measures(value) for value in node] if isinstance(node, list) else node


def _named(value: Any) -> Any:
    if isinstance(value, list):
        return [_named(each) for each in value]
    return canonical(value) if isinstance(value, Mapping) and "_target_" in value else value
