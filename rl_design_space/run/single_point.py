"""Run a single point: return its record, or learn and record it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.outcome import PointFailedError, describe_error
from rl_design_space.tracking.tracker import StoredRun, Tracker


@dataclass(frozen=True)
class PointRun:
    """The run of a single point.

    Attributes:
        stored: the run.
        result: what was learned now; None if the point had been recorded before.
    """

    stored: StoredRun
    result: LearningCurves | None

    @property
    def is_new(self) -> bool:
        """Whether the point was learned now."""
        return self.result is not None


def run_point(
    planned: PlannedPoint,
    tracker: Tracker,
    threads: int | None,
    on_wait: Callable[[], None] = lambda: None,
    *,
    poll: float = 0.5,
) -> PointRun:
    """Return the run of a point; learn and record the point if it has none.

    Args:
        planned: the point.
        tracker: finds and records runs.
        threads: number of threads that learn; all cores if None.
        on_wait: called once if another process holds the lock of this point, before waiting for it.
        poll: seconds between two attempts to lock the point.

    Raises:
        ConfigError: an option of the point cannot be used.
        PointFailedError: the learning failed, because an option raises an error.
    """
    fingerprint = planned.fingerprint
    stored = tracker.finished([fingerprint]).get(fingerprint)
    waiting = False
    while stored is None and not tracker.lock(fingerprint):
        if not waiting:
            on_wait()
        waiting = True
        time.sleep(poll)
        stored = tracker.recorded_since(fingerprint)
    stored = stored or tracker.recorded_since(fingerprint)
    try:
        if stored:
            tracker.add_studies({fingerprint: stored}, {fingerprint: planned.studies})
            return PointRun(stored, None)
        if beginning := tracker.beginnings([planned]).get(fingerprint):
            planned = replace(planned, begun=tracker.result(beginning, planned))
        result = _learned(planned, threads)
        return PointRun(tracker.record(planned, result), result)
    finally:
        tracker.unlock(fingerprint)


def _learned(planned: PlannedPoint, threads: int | None) -> LearningCurves:
    from rl_design_space.learning import simulate

    try:
        return simulate(planned.point, threads, begun=planned.begun)
    except ConfigError:
        raise
    except Exception as error:
        raise PointFailedError(describe_error(error)) from error
