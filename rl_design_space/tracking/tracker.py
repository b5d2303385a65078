"""What sweeps need of a tracking store."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rl_design_space.learning import LearningCurves
    from rl_design_space.sweep.plan import Plan, PlannedPoint


@dataclass(frozen=True)
class StoredRun:
    """A complete run of a design point.

    Attributes:
        run_id: its id in the store; empty where nothing is recorded.
        studies: the studies that it is known to belong to.
    """

    run_id: str
    studies: frozenset[str] = frozenset()


class SweepRecord(Protocol):
    """The summary run of one sweep."""

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        """End it.

        Args:
            status: FINISHED, FAILED, or KILLED if it was stopped.
            counts: points by what became of them.
            failures: what went wrong, by the command that runs the point again.
        """
        ...


class Tracker(Protocol):
    """Records design points, each once, and knows which ones it has.

    Several processes may record into one store. A point is learned by who has claimed it.
    """

    @property
    def location(self) -> str:
        """Where the records are, for people."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        ...

    def claim(self, fingerprint: str) -> bool:
        """Take a point upon this process; False while another one has it."""
        ...

    def recorded_meanwhile(self, fingerprint: str) -> StoredRun | None:
        """The complete run of a point that has come to be since `finished` was last asked, if any."""
        ...

    def release(self, fingerprint: str) -> None:
        """Give up a claim."""
        ...

    def scalars(self, run: StoredRun) -> Mapping[str, float]:
        """The numbers that sum a stored point up, see `LearningCurves.scalars`."""
        ...

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Store the result of a claimed point; the run is FINISHED only when everything is in."""
        ...

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        """Note that a stored point belongs to these studies as well."""
        ...

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs."""
        ...


class NullTracker:
    """Records nothing."""

    location = "nowhere (tracking=none)"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def claim(self, fingerprint: str) -> bool:
        return True

    def recorded_meanwhile(self, fingerprint: str) -> StoredRun | None:
        return None

    def release(self, fingerprint: str) -> None:
        pass

    def scalars(self, run: StoredRun) -> Mapping[str, float]:
        return {}

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        return StoredRun(run_id="")

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        pass

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        return self

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        pass
