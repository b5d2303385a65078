"""A tracker that keeps everything in memory."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from rl_design_space.learning import LearningCurves
from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.sweep.study import Study
from rl_design_space.tracking.tracker import StoredRun


@dataclass
class MemorySweep:
    """A summary run."""

    study: str
    status: str = "RUNNING"
    counts: dict[str, int] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    def close(self, status: str, counts: Mapping[str, int], failures: Mapping[str, str]) -> None:
        assert self.status == "RUNNING", "closed twice"
        self.status, self.counts, self.failures = status, dict(counts), dict(failures)


@dataclass
class MemoryTracker:
    """Stored runs by fingerprint, and summary runs."""

    runs: dict[str, StoredRun] = field(default_factory=dict)
    sweeps: list[MemorySweep] = field(default_factory=list)
    #: Raised when the points with these names are recorded.
    errors: Mapping[str, BaseException] = field(default_factory=dict)
    location: str = "memory"

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        return {fingerprint: self.runs[fingerprint] for fingerprint in fingerprints if fingerprint in self.runs}

    def record(self, planned: PlannedPoint, curves: LearningCurves) -> StoredRun:
        if planned.name in self.errors:
            raise self.errors[planned.name]
        assert planned.fingerprint not in self.runs, "recorded twice"
        scalars = curves.scalars(planned.point.world.shape)
        self.runs[planned.fingerprint] = StoredRun(f"run {len(self.runs)}", scalars, frozenset(planned.studies))
        return self.runs[planned.fingerprint]

    def add_studies(self, run: StoredRun, studies: Sequence[str]) -> None:
        for fingerprint, stored in self.runs.items():
            if stored.run_id == run.run_id:
                self.runs[fingerprint] = replace(stored, studies=stored.studies | set(studies))

    def open_sweep(self, study: Study) -> MemorySweep:
        self.sweeps.append(MemorySweep(study.name))
        return self.sweeps[-1]
