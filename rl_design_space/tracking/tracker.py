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

    Several processes may record into one store. A point is learned by who has claimed it. What is recorded is safe at
    once, and in the store soon.
    """

    @property
    def location(self) -> str:
        """Where the records are, for people."""
        ...

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        """The recorded points among these, by fingerprint."""
        ...

    def claim(self, fingerprint: str) -> bool:
        """Take a point upon this process; False while another one has it."""
        ...

    def recorded_meanwhile(self, fingerprint: str) -> StoredRun | None:
        """The record of a point that has come to be since `finished` was last asked, if any."""
        ...

    def release(self, fingerprint: str) -> None:
        """Give up a claim; that of a recorded point ends when the store has it."""
        ...

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        """Keep the result of a claimed point; it is safe on return."""
        ...

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        """Note that recorded points belong to these studies as well; both by fingerprint."""
        ...

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        """Start the summary run of a sweep that a command runs."""
        ...

    def settle(self, told: Callable[[int, str], None] = ...) -> Settled:
        """Wait, not for ever, until the store has everything.

        Args:
            told: is called now and then with the number of records left, and what is wrong, if anything.
        """
        ...


@dataclass
class Settled:
    """What came of records when no more was to be waited for.

    Attributes:
        awaiting: how many are safe, but not in the store yet.
        why: what kept them.
        lost: why points cannot be stored, by fingerprint.
    """

    awaiting: int = 0
    why: str = ""
    lost: Mapping[str, str] = field(default_factory=dict)


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

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        return StoredRun(scalars=curves.scalars())

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        pass

    def open_sweep(self, plan: Plan, command: str) -> SweepRecord:
        return self

    def close(self, ending: SweepEnding) -> None:
        pass

    def settle(self, told: Callable[[int, str], None] = lambda left, trouble: None) -> Settled:
        return Settled()
