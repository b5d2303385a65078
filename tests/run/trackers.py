"""A tracker that keeps everything in memory, and a monitor that keeps the events of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from rl_design_space.learning import LearningCurves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.tracking.beginnings import beginnings
from rl_design_space.tracking.tracker import Beginning, DeliveryStatus, Findings, StoredRun, SweepEnding


@dataclass
class MemorySweep:
    """A summary run."""

    name: str
    command: str
    status: str = "RUNNING"
    counts: dict[str, int] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    verdict: str = ""
    stored: dict[str, StoredRun] = field(default_factory=dict)
    findings: Findings = field(default_factory=Findings)

    def close(self, ending: SweepEnding) -> None:
        assert self.status == "RUNNING", "closed twice"
        self.status, self.counts, self.failures = ending.status, dict(ending.counts), dict(ending.failures)
        self.verdict, self.stored, self.findings = ending.verdict, dict(ending.stored), ending.findings


@dataclass
class MemoryTracker:
    """Stored runs by fingerprint, and summary runs."""

    runs: dict[str, StoredRun] = field(default_factory=dict)
    sweeps: list[MemorySweep] = field(default_factory=list)
    #: Raised when the points with these names are recorded.
    errors: Mapping[str, BaseException] = field(default_factory=dict)
    locked: set[str] = field(default_factory=set)
    #: Points that another process has locked, and how often `lock` fails before it has recorded or released them.
    busy: dict[str, int] = field(default_factory=dict)
    records_of_others: set[str] = field(default_factory=set)
    #: Points that cannot be stored, and the number of pending records.
    lost: dict[str, str] = field(default_factory=dict)
    pending: int = 0
    #: Results that can be continued.
    results: dict[str, LearningCurves] = field(default_factory=dict)
    location: str = "memory"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {fingerprint: self.runs[fingerprint] for fingerprint in fingerprints if fingerprint in self.runs}

    def beginnings(self, points: Collection[PlannedPoint]) -> dict[str, Beginning]:
        counts = [result.steps.shape[0] for result in self.results.values()]
        return beginnings(points, counts, self.finished)

    def result(self, beginning: Beginning, planned: PlannedPoint) -> LearningCurves | None:
        return self.results.get(beginning.fingerprint)

    def lock(self, fingerprint: str) -> bool:
        if self.busy.get(fingerprint, 0) > 0:
            self.busy[fingerprint] -= 1
            return False
        assert fingerprint not in self.locked, "locked twice"
        self.locked.add(fingerprint)
        if fingerprint in self.records_of_others:
            self.runs[fingerprint] = StoredRun(f"run {len(self.runs)}")
        return True

    def recorded_since(self, fingerprint: str) -> StoredRun | None:
        return self.runs.get(fingerprint)

    def unlock(self, fingerprint: str) -> None:
        self.locked.discard(fingerprint)

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        assert planned.fingerprint in self.locked, "recorded without holding the lock"
        if planned.name in self.errors:
            raise self.errors[planned.name]
        assert planned.fingerprint not in self.runs, "recorded twice"
        scalars = curves.scalars()
        run = StoredRun(f"run {len(self.runs)}", frozenset(planned.studies), scalars)
        self.runs[planned.fingerprint] = run
        self.results[planned.fingerprint] = curves
        return run

    def add_studies(self, stored: Mapping[str, StoredRun], studies: Mapping[str, Sequence[str]]) -> None:
        for fingerprint, run in stored.items():
            assert self.runs[fingerprint].run_id == run.run_id
            self.runs[fingerprint] = replace(run, studies=run.studies | set(studies.get(fingerprint, ())))

    def wait_for_delivery(
        self, on_progress: Callable[[int, str], None] = lambda pending, problem: None
    ) -> DeliveryStatus:
        on_progress(self.pending, "")
        lost, self.lost = self.lost, {}
        return DeliveryStatus(self.pending, "the store is away" if self.pending else "", lost)

    def open_sweep(self, plan: Plan, command: str) -> MemorySweep:
        self.sweeps.append(MemorySweep(plan.name, command))
        return self.sweeps[-1]


@dataclass
class MemoryMonitor:
    """The events of a sweep: names of points that started, and results by the name of the point."""

    started_points: list[str] = field(default_factory=list)
    results: dict[str, LearningCurves | StoredRun | Exception] = field(default_factory=dict)
    waited: list[int] = field(default_factory=list)

    def point_started(self, planned: PlannedPoint) -> None:
        self.started_points.append(planned.name)

    def point_learned(self, planned: PlannedPoint) -> None:
        assert planned.name in self.started_points, "learned before it was started"

    def point_ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        assert planned.name not in self.results, "ended twice"
        self.results[planned.name] = result

    def waiting(self, points: int) -> None:
        self.waited.append(points)

    def delivering(self, pending: int, problem: str) -> None:
        pass
