"""Which points of a sweep cannot be told from the best: its periods are compared in pairs when it ends."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.runner import SweepMonitor
from rl_design_space.tracking.tracker import Beginning, Findings, StoredRun, Tracker

if TYPE_CHECKING:
    from rl_design_space._arrays import FloatArray
    from rl_design_space.run.outcome import Outcome

#: Most points, and periods of all of them, that are compared: that takes less than a second.
_MOST, _PERIODS = 200, 200_000
#: Of points that differ in these, periods are no pairs, or unequally many.
_UNPAIRED = ("seed", "task.periods")


class BestPoints:
    """A monitor that keeps the total steps of each period, and passes all events on to a display.

    Args:
        plan: the points of the sweep.
        tracker: has the results of points that are not learned now.
        display: receives the events.
    """

    def __init__(self, plan: Plan, tracker: Tracker, display: SweepMonitor) -> None:
        self._plan, self._tracker, self._display = plan, tracker, display
        self._is_small = 1 < len(plan) <= _MOST and sum(each.point.task.periods for each in plan) <= _PERIODS
        self._totals: dict[str, FloatArray] = {}
        self.point_started, self.point_learned = display.point_started, display.point_learned
        self.waiting, self.delivering = display.waiting, display.delivering

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """Keep the total steps of a point that was learned now."""
        if isinstance(result, LearningCurves) and self._is_small:
            self._totals[planned.fingerprint] = result.total_steps
        self._display.point_ended(planned, result)

    def findings(self, outcome: Outcome) -> Findings:
        """Return the points that cannot be told from the best; not of points that cannot be compared, or too many."""
        if not self._is_small or not self._plan.axes.keys().isdisjoint(_UNPAIRED):
            return Findings()
        stored = [planned for planned in self._plan if planned.fingerprint in outcome.stored]
        if len(stored) < 2 or any(planned.point.task.precision is not None for planned in stored):
            return Findings()
        totals = list(self._read(stored, outcome))
        if len(totals) < len(stored) or len(totals[0]) < 2:
            return Findings()
        import numpy as np

        from rl_design_space.analysis.best import best_means

        inside = best_means(np.stack(totals, axis=1)).inside.tolist()
        best = (planned.fingerprint for planned, is_inside in zip(stored, inside, strict=True) if is_inside)
        return Findings(best=frozenset(best), best_by="total_steps")

    def _read(self, points: Iterable[PlannedPoint], outcome: Outcome) -> Iterable[FloatArray]:
        """Yield the total steps of points, until one of them did not keep its periods."""
        for planned in points:
            totals = self._totals.get(planned.fingerprint)
            if totals is None:
                run = outcome.stored[planned.fingerprint]
                beginning = Beginning(planned.fingerprint, planned.point.task.periods, run)
                result = self._tracker.result(beginning, planned)
                if result is None:
                    return
                totals = result.total_steps
            yield totals
