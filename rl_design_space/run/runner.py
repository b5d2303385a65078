"""Run a plan: skip the recorded points, learn the others, record each once."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass, field, replace
from math import isnan
from typing import Literal, Protocol

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_work
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.executor import Executor
from rl_design_space.run.local_executor import LocalExecutor
from rl_design_space.run.outcome import Outcome, describe_error, summary_run
from rl_design_space.run.recorder import Recorder
from rl_design_space.tracking.tracker import Beginning, Findings, StoredRun, Tracker

OnError = Literal["continue", "stop"]
#: Seconds of compiling that a summary names.
_WORTH_TELLING = 0.5


class SweepMonitor(Protocol):
    """Receives the events of a sweep, from several threads."""

    def point_started(self, planned: PlannedPoint) -> None:
        """Handle the start of a point."""
        ...

    def point_learned(self, planned: PlannedPoint) -> None:
        """Handle a point that was learned or failed and is not recorded yet."""
        ...

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """Handle the end of a point.

        Args:
            planned: the point.
            result: learning curves if this process recorded the point, its run if another process did, or the error.
        """
        ...

    def waiting(self, points: int) -> None:
        """Handle that other processes hold the locks of the points that are left: so many, or 0 when none is left."""
        ...

    def delivering(self, pending: int, problem: str) -> None:
        """Handle progress of the delivery, after all points were learned.

        Args:
            pending: number of pending records.
            problem: what is wrong with the store; empty if nothing is.
        """
        ...


@dataclass(frozen=True)
class Missing:
    """The points of a plan that have no complete run.

    Attributes:
        points: these points, in descending order of expected cost.
        stored: the runs of the other points, by fingerprint.
        begun: runs of the missing points with other numbers of periods, by their fingerprints.
    """

    points: list[PlannedPoint]
    stored: Mapping[str, StoredRun]
    begun: Mapping[str, Beginning] = field(default_factory=dict)

    def steps_left(self, planned: PlannedPoint) -> float:
        """Return the approximate number of steps of Q-learning that would take as long as a point still needs."""
        beginning = self.begun.get(planned.fingerprint)
        return expected_work(planned.point, beginning.periods if beginning else planned.periods_begun)


def missing(plan: Plan, tracker: Tracker) -> Missing:
    """Return the points of a plan that a tracker has no complete run of."""
    stored = tracker.finished([planned.fingerprint for planned in plan])
    points = [planned for planned in plan if planned.fingerprint not in stored]
    begun = (
        tracker.beginnings([planned for planned in points if planned.begun is None and not planned.measured_by])
        if points
        else {}
    )
    found = Missing(points, stored, begun)
    return replace(found, points=sorted(points, key=found.steps_left, reverse=True))


def run_sweep(
    plan: Plan,
    tracker: Tracker,
    executor: Executor,
    monitor: SweepMonitor,
    *,
    command: str = "",
    on_error: OnError = "continue",
    found: Missing | None = None,
    summarised: bool = True,
    findings: Callable[[Outcome], Findings] | None = None,
) -> Outcome:
    """Run the points of a plan that have no complete run.

    Args:
        plan: the points of the sweep.
        tracker: records results.
        executor: learns the points.
        monitor: receives the events of the sweep.
        command: the command line of this sweep, which the summary run records.
        on_error: `stop` starts no further point after one has failed.
        found: the result of `missing`, if it is known already.
        summarised: whether the sweep gets a summary run.
        findings: returns what the sweep has found out when all points are recorded, which its summary run shows.
    """
    found = found or missing(plan, tracker)
    outcome = Outcome(len(plan), already=len(found.stored), stored=dict(found.stored))
    add_studies(plan, found.stored, tracker)
    if found.points:
        with summary_run(plan, outcome, tracker, command) if summarised else nullcontext():
            learn_missing(found, tracker, executor, monitor, outcome, on_error)
            started = time.perf_counter()
            outcome.count_lost(tracker.wait_for_delivery(monitor.delivering).lost)
            outcome.seconds["delivery"] = time.perf_counter() - started
            outcome.findings = findings(outcome) if findings else outcome.findings
    elif findings:
        outcome.findings = findings(outcome)
    outcome.delivery = tracker.wait_for_delivery(monitor.delivering)
    return outcome


def learn_missing(
    found: Missing, tracker: Tracker, executor: Executor, monitor: SweepMonitor, outcome: Outcome, on_error: OnError
) -> None:
    """Learn and record points, and count them in an outcome; their delivery is not waited for.

    Args:
        found: the points.
        tracker: records results.
        executor: learns the points.
        monitor: receives the events of the sweep.
        outcome: of the sweep.
        on_error: `stop` starts no further point after one has failed.
    """
    _Sweep(tracker, monitor, outcome, found.begun).learn(found.points, executor, on_error)


def add_studies(plan: Plan, stored: Mapping[str, StoredRun], tracker: Tracker) -> None:
    """Add the studies of a plan to the stored runs of its points."""
    tracker.add_studies(stored, {planned.fingerprint: planned.studies for planned in plan})


class _Sweep:
    """Locks, learns and records points, and counts them in an outcome."""

    def __init__(
        self, tracker: Tracker, monitor: SweepMonitor, outcome: Outcome, begun: Mapping[str, Beginning]
    ) -> None:
        self._tracker = tracker
        self._begun = begun
        self._monitor = monitor
        self._outcome = outcome
        self._learning_seconds = 0.0
        #: Fingerprints of points that were started and have not ended; this process holds their locks.
        self._started: set[str] = set()

    def learn(self, points: Sequence[PlannedPoint], executor: Executor, on_error: OnError) -> None:
        outcome = self._outcome
        try:
            with (
                Recorder(self._tracker, self._point_ended) as recorder,
                closing(executor.learn(self._lockable(points))) as results,
            ):
                for planned, result in results:
                    self._monitor.point_learned(planned)
                    recorder.put(planned, result)
                    if on_error == "stop" and (outcome.failed or isinstance(result, Exception)):
                        break
        finally:
            for fingerprint in self._started:
                self._tracker.unlock(fingerprint)
        spent = {"learning": self._learning_seconds, "recording": recorder.seconds}
        if isinstance(executor, LocalExecutor) and executor.compiling >= _WORTH_TELLING:
            spent = {"compiling": executor.compiling, **spent}
        for activity, seconds in spent.items():
            outcome.seconds[activity] = outcome.seconds.get(activity, 0.0) + seconds

    def _point_ended(self, planned: PlannedPoint, result: LearningCurves | Exception, stored: StoredRun | None) -> None:
        outcome = self._outcome
        self._started.discard(planned.fingerprint)
        if isinstance(result, Exception):
            outcome.failed[planned.fingerprint] = describe_error(result)
        else:
            outcome.done += 1
            if stored:
                outcome.stored[planned.fingerprint] = stored
            begun = planned.begun
            outcome.steps += float(result.total_steps[planned.periods_begun :].sum())
            before = 0.0 if begun is None or isnan(begun.seconds) else begun.seconds
            self._learning_seconds += 0.0 if isnan(result.seconds) else max(0.0, result.seconds - before)
        self._monitor.point_ended(planned, result)

    def _lockable(self, points: Sequence[PlannedPoint]) -> Iterator[PlannedPoint | None]:
        """Lock and yield the points one by one; yield None while other processes hold the locks of the remaining ones.

        Points that another process has recorded since are counted and skipped.
        """
        left = points
        while left:
            busy = []
            for planned in left:
                if not self._tracker.lock(planned.fingerprint):
                    busy.append(planned)
                elif stored := self._tracker.recorded_since(planned.fingerprint):
                    self._tracker.unlock(planned.fingerprint)
                    self._skip(planned, stored)
                else:
                    self._started.add(planned.fingerprint)
                    self._monitor.point_started(planned)
                    yield self._continued(planned)
            left = busy
            self._monitor.waiting(len(left))
            if left:
                yield None

    def _continued(self, planned: PlannedPoint) -> PlannedPoint:
        """Return a point with the result of its first periods, if they have been recorded."""
        beginning = self._begun.get(planned.fingerprint)
        return replace(planned, begun=self._tracker.result(beginning, planned)) if beginning else planned

    def _skip(self, planned: PlannedPoint, stored: StoredRun) -> None:
        self._tracker.add_studies({planned.fingerprint: stored}, {planned.fingerprint: planned.studies})
        self._outcome.elsewhere += 1
        self._outcome.stored[planned.fingerprint] = stored
        self._monitor.point_ended(planned, stored)
