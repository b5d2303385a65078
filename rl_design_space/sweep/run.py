"""Run planned points: skip what is stored, learn the rest, record each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from rl_design_space.sweep.plan import PlannedPoint
from rl_design_space.sweep.study import Study
from rl_design_space.tracking.tracker import StoredRun, SweepRecord, Tracker


@dataclass
class Outcome:
    """What became of the points of a sweep, by fingerprint."""

    already: dict[str, StoredRun] = field(default_factory=dict)
    done: dict[str, StoredRun] = field(default_factory=dict)
    failed: dict[str, Exception] = field(default_factory=dict)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of points: stored before, learned now, failed."""
        return {"already": len(self.already), "done": len(self.done), "failed": len(self.failed)}


def run_point(planned: PlannedPoint, tracker: Tracker, threads: int | None) -> tuple[StoredRun, bool]:
    """The stored result of a point, and whether it had to be learned for it."""
    stored = tracker.finished([planned.fingerprint]).get(planned.fingerprint)
    if stored:
        tracker.add_studies(stored, planned.studies)
        return stored, False
    return _learn(planned, tracker, threads), True


def run_sweep(
    study: Study,
    tracker: Tracker,
    threads: int | None,
    report: Callable[[PlannedPoint, StoredRun | Exception], None],
) -> Outcome:
    """Run the points of a plan that the tracker does not have; a point that fails does not stop the others.

    Args:
        study: what to run; its summary run has its name.
        tracker: where results go.
        threads: cores that learn, all if None.
        report: is told of every point that ends.
    """
    plan = study.plan
    outcome = Outcome(already=tracker.finished([planned.fingerprint for planned in plan]))
    for planned in plan:
        if planned.fingerprint in outcome.already:
            tracker.add_studies(outcome.already[planned.fingerprint], planned.studies)
    missing = [planned for planned in plan if planned.fingerprint not in outcome.already]
    if not missing:
        return outcome

    summary = tracker.open_sweep(study)
    # Closed here whatever happens: Hydra's own end-of-run callbacks do not fire when a job fails.
    status = "KILLED"
    try:
        for planned in missing:
            result: StoredRun | Exception
            try:
                result = outcome.done[planned.fingerprint] = _learn(planned, tracker, threads)
            except Exception as error:
                result = outcome.failed[planned.fingerprint] = error
            report(planned, result)
        status = "FAILED" if outcome.failed else "FINISHED"
    finally:
        _close(summary, status, plan, outcome)
    return outcome


def _learn(planned: PlannedPoint, tracker: Tracker, threads: int | None) -> StoredRun:
    from rl_design_space.learning import simulate

    return tracker.record(planned, simulate(planned.point, threads))


def _close(summary: SweepRecord, status: str, plan: Sequence[PlannedPoint], outcome: Outcome) -> None:
    failures = {
        planned.command: repr(outcome.failed[planned.fingerprint])
        for planned in plan
        if planned.fingerprint in outcome.failed
    }
    summary.close(status, outcome.counts, failures)
