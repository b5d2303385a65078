"""Constraints: named rules that exclude meaningless combinations from a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.assemble import Parts
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError
from rl_design_space.plan.expression import Expression


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Constraint:
    """A rule that excludes combinations from a study.

    Attributes:
        drop: an expression over the values of a point, under the names that they have on the command line; points for
            which it is true are dropped. A choice is the name of its option, and its dotted names are the option's
            values: `representation == "direction" and max(msa.lengths, default=1) >= min(world.shape)`.
        why: the reason, which the plan shows.
    """

    drop: Annotated[str, Field(min_length=1)]
    why: Annotated[str, Field(min_length=1)]

    def drops(self, parts: Parts) -> bool:
        """Return whether the point with these parts is dropped.

        Raises:
            ConfigError: the expression cannot be evaluated.
        """
        expression = self._expression
        try:
            return bool(expression.value(lambda name: _value_of(parts, name)))
        except ConfigError as error:
            chosen = " ".join(f"{group}={option}" for group, option in parts.options.items())
            raise ConfigError.at("drop", self.drop, f"{error}, for a point with {chosen}") from error

    @cached_property
    def _expression(self) -> Expression:
        try:
            return Expression(self.drop)
        except ConfigError as error:
            raise ConfigError.at("drop", self.drop, str(error)) from error


def _value_of(parts: Parts, name: str) -> Any:
    """Return the value of a name: the name of an option, or a value of it by its dotted name.

    Raises:
        ConfigError: there is none of this name.
    """
    choice, *keys = name.split(".")
    if choice not in parts.values:
        raise ConfigError.unknown("name", choice, parts.values)
    if not keys and choice in parts.options:
        return parts.options[choice]
    value, above = parts.values[choice], choice
    for key in keys:
        if not _is_readable(value, key):
            raise ConfigError.unknown("value", key, _readable(value), f"{above}.")
        value, above = getattr(value, key), f"{above}.{key}"
    if is_dataclass(value):
        known = ", ".join(f"{name}.{key}" for key in _readable(value))
        raise ConfigError(f"{name}: name one of its values: {known}")
    return value


def _is_readable(component: Any, name: str) -> bool:
    """Return whether a component has a field or public property of this name."""
    if not is_dataclass(component):
        return False
    if any(field.name == name for field in fields(component)):
        return True
    return not name.startswith("_") and isinstance(getattr(type(component), name, None), (property, cached_property))


def _readable(component: Any) -> list[str]:
    """Return the names of the fields and public properties of a component."""
    return [name for name in dir(component) if _is_readable(component, name)]


def constraints_of(node: Any) -> Mapping[str, Constraint]:
    """Return the constraints in a study's file, by name.

    Raises:
        ConfigError: they are not a mapping of names to `drop` and `why`.
    """
    if node is None:
        return {}
    if not isinstance(node, Mapping) or not all(isinstance(fields_, Mapping) for fields_ in node.values()):
        raise ConfigError("constraints: should be a mapping of names to {drop: EXPRESSION, why: REASON}")
    return {name: construct(Constraint, values, f"constraints.{name}") for name, values in node.items()}
