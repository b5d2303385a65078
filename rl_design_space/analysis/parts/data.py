"""How parts of claims get the recorded points that they compare."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from typing_extensions import Protocol, runtime_checkable

from rl_design_space.analysis.tested import Tested
from rl_design_space.learning.result import LearningCurves

Where = dict[str, Any]


class Data(Protocol):
    """Recorded points by the values of their parameters."""

    def one(self, where: Where) -> LearningCurves:
        """Return the only point with these values.

        Raises:
            LookupError: it has not been recorded.
        """
        ...

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        """Return all points with these values, by their value of another parameter.

        Raises:
            LookupError: one of them has not been recorded.
        """
        ...


@runtime_checkable
class Part(Protocol):
    """A part of a claim."""

    def test(self, data: Data) -> Tested:
        """Test this part on recorded data.

        Raises:
            LookupError: a point that it needs has not been recorded.
        """
        ...

    def refused(self) -> tuple[float, ...]:
        """Return the paper's own numbers that the range of this part does not admit."""
        ...
