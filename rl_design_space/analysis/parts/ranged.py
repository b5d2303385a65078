"""The base of parts: a description, a range, and the paper's own numbers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Any

from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.parts.data import Where
from rl_design_space.analysis.tested import Tested, bounds_in_range

Text = Annotated[str, Field(min_length=1)]
Choice = Annotated[Where, Field(min_length=1)]


def _own_numbers(given: Any) -> Any:
    """Return the paper's own numbers; a pair of them stands for its quotient."""
    each = given if isinstance(given, (list, tuple)) else [given]
    numbers = [_quotient(*one) if isinstance(one, (list, tuple)) and len(one) == 2 else one for one in each]
    if not all(type(number) in (int, float) for number in numbers):
        raise ValueError("should be numbers of the paper, or pairs of them, each of which stands for its quotient")
    return tuple(map(float, numbers))


def _quotient(one: Any, other: Any) -> Any:
    return one / other if type(one) in (int, float) and type(other) in (int, float) and other else None


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Ranged:
    """A description of a statistic and the range that a claim gives for it.

    Attributes:
        what: description of the statistic.
        low: lower end of the range; none if left out.
        high: upper end of the range; none if left out.
        paper: the paper's own values of the statistic, if it gives any; a pair of its numbers stands for their
            quotient. A range that they would fail is not what the paper says.
    """

    what: Text
    low: float | None = None
    high: float | None = None
    paper: Annotated[tuple[float, ...], BeforeValidator(_own_numbers)] = ()

    def refused(self) -> tuple[float, ...]:
        """Return the paper's own numbers that the range does not admit."""
        low, high = self.range
        return tuple(number for number in self.paper if not low <= number <= high)

    @property
    def range(self) -> tuple[float, float]:
        """Both ends of the range, infinite where none is given."""
        return (-math.inf if self.low is None else self.low, math.inf if self.high is None else self.high)

    def _tested(self, value: Bounds, samples: Bounds) -> Tested:
        tested = bounds_in_range(self.what, value, samples, *self.range)
        if refused := self.refused():
            numbers = ", ".join(f"{number:.3g}" for number in refused)
            return replace(tested, remarks=(f"the paper's own {numbers} would fail this range",))
        return tested
