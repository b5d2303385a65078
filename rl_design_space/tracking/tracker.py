"""What sweeps need of a tracking store."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rl_design_space.learning import LearningCurves
    from rl_design_space.plan.plan import Plan, PlannedPoint


@dataclass(frozen=True)
class StoredRun:
    """A complete run of a design point.

    Attributes:
        run_id: its id in the store; empty where nothing is recorded, or not yet.
        studies: the studies that it is known to belong to.
        scalars: the numbers that sum the point up, see `LearningCurves.scalars`.
        artifacts: where the store keeps its files.
    """

    run_id: str = ""
    studies: frozenset[str] = frozenset()
    scalars: Mapping[str, float] = field(default_factory=dict)
    artifacts: str = ""


class SweepRecord(Protocol):
    """The summary run of one sweep."""

    def close(self, ending: SweepEnding) -> None:
        """End it."""
        ...


@dataclass(frozen=True)
class SweepEnding:
    """How a sweep ended.

    Attributes:
        status: FINISHED, FAILED, or KILLED if it was stopped.
        verdict: the same in a line for people.
        counts: points by what became of them.
        failures: what went wrong, by the command that runs the point again.
        stored: the complete runs of its points, by fingerprint.
    """

    status: str
    verdict: str
    counts: Mapping[str, int]
    failures: Mapping[str, str]
    stored: Mapping[str, StoredRun]


class Tracker(Protocol):
    """Records design points, each once, and knows which ones it has.

    Several processes may record into one store. Only the process that holds the lock of a point learns it. A recorded
    result is on disk at once (a pending record) and is delivered to the store in the background.
    """

    @property
    def location(self) -> str:
        """Where the records are, for people."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The recorded points among these, by fingerprint."""
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
    """

    pending: int = 0
    reason: str = ""
    lost: Mapping[str, str] = field(default_factory=dict)


class NullTracker:
    """Records nothing."""

    location = "nowhere (tracking=none)"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def lock(self, fingerprint: str) -> bool:
        return True

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        return None

    def unlock(self, fingerprint: str) -> None:
        pass

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        return StoredRun(scalars=curves.scalars())

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
