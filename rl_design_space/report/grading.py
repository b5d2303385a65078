"""How numbers are graded."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct

#: From much to nothing; a number that keeps no limit gets the last one.
GRADES = ("++", "+", "0", "−")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Grading:
    """How a column is graded.

    Attributes:
        means: what the number is.
        limits: for ++, + and 0; a number gets the first grade whose limit it keeps.
        larger: whether a limit is kept by a number that is at least as large, rather than at most.
        of_least: whether limits are in multiples of the column's least number.
        of: the quantity that is graded; without it, columns are graded in the order of the report's quantities.
    """

    means: Annotated[str, Field(min_length=1)]
    limits: Annotated[tuple[float, float, float], Field(strict=False)]
    larger: bool = False
    of_least: bool = False
    of: str = ""

    def grade(self, number: float, least: float = 1.0) -> str:
        """Return the grade of a number in a column whose least number is `least`."""
        measured = number / least if self.of_least and least else number
        for grade, limit in zip(GRADES, self.limits, strict=False):
            if (measured >= limit) if self.larger else (measured <= limit):
                return grade
        return GRADES[-1]

    def rule(self) -> str:
        """Return the limits in words."""
        sign = "≥" if self.larger else "≤"
        unit = " × the least" if self.of_least else ""
        limits = ", ".join(f"{grade} {sign} {limit:g}{unit}" for grade, limit in zip(GRADES, self.limits, strict=False))
        return f"{limits}, otherwise {GRADES[-1]}"


def built(node: Mapping[str, Any], key: str) -> Grading:
    """Build a grading from its values.

    Args:
        node: values by name.
        key: of the node in the study, for messages.

    Raises:
        ConfigError: it has a value that is not allowed.
    """
    return construct(Grading, node, key)
