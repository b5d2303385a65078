"""Results and learning curves of points, read from their runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.points import Point

if TYPE_CHECKING:
    from rl_design_space.tracking.reader import Reader


class Results:
    """Results of points; each is read once, unless it is forgotten.

    Args:
        reader: of the tracking store.
    """

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._results: dict[Point, LearningCurves | None] = {}
        #: Learning curves of what was read; they are small, and stay when results are forgotten.
        self._curves: dict[Point, dict[str, FloatArray]] = {}

    def of(self, point: Point) -> LearningCurves | None:
        """Return the result of a point; None if it has no run, or its run did not keep its periods."""
        if point not in self._results:
            arrays = self._arrays(point)
            self._results[point] = (
                LearningCurves.of_arrays(arrays, point.of_plan.point)
                if point.of_plan and "steps" in arrays
                else LearningCurves.found(arrays, point.parameters.get("world.size"))
            )
        return self._results[point]

    def curves(self, point: Point) -> dict[str, FloatArray]:
        """Return the learning curves of a point by name, (trials,) each."""
        if point not in self._curves:
            self._arrays(point)
        return self._curves[point]

    def forget(self, point: Point) -> None:
        """Free the memory of a result that is not needed again."""
        self._results.pop(point, None)

    def _arrays(self, point: Point) -> dict[str, NDArray[Any]]:
        arrays = self._reader.periods(point.run) if point.run else {}
        self._curves[point] = {name: array for name, array in arrays.items() if array.ndim == 1}
        return arrays
