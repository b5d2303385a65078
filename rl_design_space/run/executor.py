"""The interface of executors, which learn the points of a sweep."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Protocol

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import PlannedPoint

#: A point, and its learning curves or the error that it raised.
PointResult = tuple[PlannedPoint, LearningCurves | Exception]


class Executor(Protocol):
    """Learns many points at a time."""

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[PointResult, None, None]:
        """Yield the result of each point, in the order in which they become ready.

        Closing the generator stops all learning.

        Args:
            points: the points to learn. A point is taken only shortly before it can start, because taking it locks it.
                None means that no point is available yet, but one may be later. The iterator is never advanced by two
                threads at once, but not always by the same thread.
        """
        ...

    def describe(self) -> str:
        """Return a description for messages, e.g. `2 threads`."""
        ...
