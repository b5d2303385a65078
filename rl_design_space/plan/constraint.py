"""Constraints: named rules that exclude meaningless combinations from a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property
from types import CodeType
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.assemble import Parts
from rl_design_space.config.build import construct
from rl_design_space.errors import ConfigError

#: Functions that an expression may call.
_FUNCTIONS = {function.__name__: function for function in (abs, all, any, len, max, min, range, round, set, sum)}


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Constraint:
    """A rule that excludes combinations from a study.

    Attributes:
        drop: a Python expression over the values of a point, under the names that they have on the command line;
            points for which it is true are dropped. A choice is the name of its option, and its attributes are the
            option's values: `representation == "direction" and max(msa.lengths, default=1) >= min(world.shape)`.
        why: the reason, which the plan shows.
    """

    drop: Annotated[str, Field(min_length=1)]
    why: Annotated[str, Field(min_length=1)]

    def drops(self, parts: Parts) -> bool:
        """Return whether the point with these parts is dropped.

        Raises:
            ConfigError: the expression cannot be evaluated.
        """
        names = {name: _named(parts.options.get(name), value) for name, value in parts.values.items()}
        try:
            return bool(eval(self._code, {"__builtins__": {}, **_FUNCTIONS, **names}))
        except Exception as error:
            chosen = " ".join(f"{group}={option}" for group, option in parts.options.items())
            raise ConfigError.at("drop", self.drop, f"{error}, for a point with {chosen}") from error

    @cached_property
    def _code(self) -> CodeType:
        try:
            return compile(self.drop, "drop", "eval")
        except SyntaxError as error:
            raise ConfigError.at("drop", self.drop, f"should be a Python expression: {error.msg}") from error


class _Option(str):
    """The name of an option, with the values of the option as attributes."""

    _component: Any

    def __getattr__(self, name: str) -> Any:
        return getattr(self._component, name)


def _named(option: str | None, value: Any) -> Any:
    if option is None:
        return value
    named = _Option(option)
    named._component = value
    # Instance attributes take precedence over the methods of str with the same name.
    if is_dataclass(value):
        named.__dict__.update({field.name: getattr(value, field.name) for field in fields(value)})
    return named


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
