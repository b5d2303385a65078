"""Trackers: the interface between sweeps and a tracking store."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rl_design_space.learning.precision import Precision

if TYPE_CHECKING:
    from rl_design_space.design import Task
    from rl_design_space.learning import LearningCurves
    from rl_design_space.plan.plan import Plan, PlannedPoint


class Enough(NamedTuple):
    """How many periods the precision of a point needed.

    Attributes:
        periods: their number.
        is_reached: whether the precision is reached; otherwise it is the maximum number.
    """

    periods: int
    is_reached: bool


@dataclass(frozen=True)
class StoredRun:
    """A complete run of a design point.

    Attributes:
        run_id: its id in the store; empty if there is no store, or while its record is pending.
        studies: names of the studies that it belongs to.
        scalars: scalars by name, see `LearningCurves.scalars`.
        artifacts: URI of the folder of its files.
        enough: how many periods it has, if the point asks for a precision; None if it asks for a number.
    """

    run_id: str = ""
    studies: frozenset[str] = frozenset()
    scalars: Mapping[str, float] = field(default_factory=dict)
    artifacts: str = ""
    enough: Enough | None = None


@dataclass(frozen=True)
class Beginning:
    """A recorded run of a point with another number of periods.

    Attributes:
        fingerprint: of the point with so many periods.
        periods: their number.
        run: the run.
    """

    fingerprint: str
    periods: int
    run: StoredRun


def recorded_as(planned: PlannedPoint, run: StoredRun | None) -> PlannedPoint:
    """Return a point with as many periods as its run has: it may ask for a precision."""
    return planned.with_periods(run.enough.periods) if run and run.enough else planned


def enough_periods(task: Task, learned: LearningCurves) -> Enough | None:
    """Return how many periods the precision of a point needed; None if it asks for none."""
    rule = Precision.of_task(task)
    return Enough(len(learned.steps), rule.reached(learned) <= rule.relative) if rule else None


class SweepRecord(Protocol):
    """The summary run of a sweep."""

    def close(self, ending: SweepEnding) -> None:
        """End the run."""
        ...


@dataclass(frozen=True)
class Findings:
    """What a sweep found out, beside the results of its points.

    Attributes:
        plan: the points with as many periods as they got, if that was decided on the way; None if as planned.
        best: fingerprints of the points that cannot be told from the best; None if that is not known.
        best_by: the measure by which that is so; empty if it is what the points are ranked by.
        lines: for the note of the summary run.
        tables: CSV files of the summary run, by name.
        metrics: of the summary run, by name.
    """

    plan: Plan | None = None
    best: frozenset[str] | None = None
    best_by: str = ""
    lines: Sequence[str] = ()
    tables: Mapping[str, bytes] = field(default_factory=dict)
    metrics: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class SweepEnding:
    """How a sweep ended.

    Attributes:
        status: FINISHED, FAILED, or KILLED if it was stopped.
        verdict: one line with the numbers of points by outcome.
        counts: numbers of points by outcome.
        failures: error messages, by the command that runs the point again.
        stored: the complete runs of its points, by fingerprint.
        findings: what it found out beside these.
    """

    status: str
    verdict: str
    counts: Mapping[str, int]
    failures: Mapping[str, str]
    stored: Mapping[str, StoredRun]
    findings: Findings = field(default_factory=Findings)


class Tracker(Protocol):
    """Records design points, each once, and finds those that are recorded.

    Several processes may record into one store. Only the process that holds the lock of a point learns it. A recorded
    result is on disk at once (a pending record) and is delivered to the store in the background.
    """

    @property
    def location(self) -> str:
        """Where results are recorded, for messages."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """Return the recorded points among these, by fingerprint."""
        ...

    def beginnings(self, points: Collection[PlannedPoint]) -> dict[str, Beginning]:
        """Return the longest recorded run of each of these points with another number of periods, by fingerprint."""
        ...

    def result(self, beginning: Beginning, planned: PlannedPoint) -> LearningCurves | None:
        """Return the result of such a run; None if it cannot be read, or is not what was recorded."""
        ...

    def lock(self, fingerprint: str) -> bool:
        """Lock a point for this process; return False while another process holds its lock."""
        ...

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        """Return the record of a point that was written after the last call of `finished`, if any."""
        ...

    def unlock(self, fingerprint: str) -> None:
        """Release the lock of a point; a pending record keeps it locked until it is delivered."""
        ...

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Write the result of a locked point to disk; it is durable on return."""
        ...

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        """Note that recorded points belong to these studies as well; both by fingerprint."""
        ...

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs."""
        ...

    def wait_for_delivery(self, on_progress: Callable[[int, str], None] = ...) -> DeliveryStatus:
        """Wait until every pending record is delivered, or until the tracker's patience ends.

        Args:
            on_progress: called from time to time with the number of pending records and the current problem, which is
                empty if there is none.
        """
        ...


@dataclass
class DeliveryStatus:
    """Delivery status when `wait_for_delivery` returns.

    Attributes:
        pending: number of pending records: on disk, not yet in the store.
        reason: why they are not delivered.
        lost: why points cannot be stored, by fingerprint.
        note: what users should know about recording into this store; usually empty.
        spools: folder of the pending records.
    """

    pending: int = 0
    reason: str = ""
    lost: Mapping[str, str] = field(default_factory=dict)
    note: str = ""
    spools: str = ""


class NullTracker:
    """A tracker that records nothing."""

    location = "nowhere (tracking=none)"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def beginnings(self, points: Collection[PlannedPoint]) -> dict[str, Beginning]:
        return {}

    def result(self, beginning: Beginning, planned: PlannedPoint) -> LearningCurves | None:
        return None

    def lock(self, fingerprint: str) -> bool:
        return True

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        return None

    def unlock(self, fingerprint: str) -> None:
        pass

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        return StoredRun(scalars=curves.scalars(), enough=enough_periods(planned.point.task, curves))

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        pass

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        return self

    def close(self, ending: SweepEnding) -> None:
        pass

    def wait_for_delivery(
        self, on_progress: Callable[[int, str], None] = lambda pending, problem: None
    ) -> DeliveryStatus:
        return DeliveryStatus()
