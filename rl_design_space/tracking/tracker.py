"""What sweeps need of a tracking store."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rl_design_space.learning import LearningCurves
    from rl_design_space.sweep.plan import PlannedPoint
    from rl_design_space.sweep.study import Study


@dataclass(frozen=True)
class StoredRun:
    """A complete run of a design point.

    Attributes:
        run_id: its id in the store; empty where nothing is recorded.
        scalars: the numbers that sum it up, see `LearningCurves.scalars`.
        studies: the studies that it is known to belong to.
    """

    run_id: str
    scalars: Mapping[str, float]
    studies: frozenset[str] = frozenset()


class SweepRecord(Protocol):
    """The summary run of one sweep."""

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        """End it.

        Args:
            status: FINISHED, FAILED or KILLED.
            counts: points by what became of them.
            failures: what went wrong, by the command that runs the point again.
        """
        ...


class Tracker(Protocol):
    """Records design points, each once, and knows which ones it has."""

    @property
    def location(self) -> str:
        """Where the records are, for people."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The complete runs among these points, by fingerprint."""
        ...

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Store a point's result; the run is FINISHED only when everything is in."""
        ...

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        """Note that a stored point belongs to these studies as well."""
        ...

    def open_sweep(self, study: Study) -> SweepRecord:
        """Start the summary run of a sweep."""
        ...


class NullTracker:
    """Records nothing."""

    location = "nowhere (tracking=none)"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {}

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        return StoredRun(run_id="", scalars=curves.scalars(planned.point.world.shape))

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        pass

    def open_sweep(self, study: Study) -> SweepRecord:
        return self

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        pass
