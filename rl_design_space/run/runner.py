"""Run planned points: skip what is stored, learn the rest, record each once."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import Literal, Protocol

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_moves
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.run.executor import Executor
from rl_design_space.run.recorder import Recorder
from rl_design_space.tracking.tracker import DeliveryStatus, StoredRun, SweepEnding, Tracker

#: Numbers of points by what became of them, in words.
_COUNTED = {
    "already": "recorded before",
    "done": "learned now",
    "elsewhere": "by another process",
    "failed": "failed",
    "left": "not run",
}
#: Seconds between two looks at a point that another process is learning.
_PATIENCE = 0.5


class Watcher(Protocol):
    """Is told what becomes of the points of a sweep."""

    def started(self, planned: PlannedPoint) -> None:
        """A point is about to be learned."""
        ...

    def learned(self, planned: PlannedPoint) -> None:
        """A point has been learned, or has failed; it waits to be recorded."""
        ...

    def ended(self, planned: PlannedPoint, result: LearningCurves | StoredRun | Exception) -> None:
        """A point has been recorded, by this process or by another one; or it has failed."""
        ...

    def waiting(self, left: int, trouble: str) -> None:
        """All is learned; so many records are still to be told to the store, and this is wrong with it, if anything."""
        ...


@dataclass
class Outcome:
    """What became of the points of a sweep.

    Attributes:
        points: how many there are.
        already: recorded before.
        done: learned and recorded now.
        elsewhere: recorded meanwhile by another process.
        failed: what went wrong, by the fingerprint of the point.
        stored: the records of all others, by fingerprint.
        delivery: which records are not delivered yet, or cannot be.
        moves: primitive moves learned.
        seconds: time spent, by what on; learning is the sum over all threads.
    """

    points: int = 0
    already: int = 0
    done: int = 0
    elsewhere: int = 0
    failed: dict[str, str] = field(default_factory=dict)
    stored: dict[str, StoredRun] = field(default_factory=dict)
    delivery: DeliveryStatus = field(default_factory=DeliveryStatus)
    moves: float = 0.0
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of points by what became of them."""
        left = self.points - self.already - self.done - self.elsewhere - len(self.failed)
        return {
            "already": self.already,
            "done": self.done,
            "elsewhere": self.elsewhere,
            "failed": len(self.failed),
            "left": left,
        }

    def lose(self, lost: Mapping[str, str]) -> None:
        """Count points as failed whose records cannot be stored; why, by fingerprint."""
        for fingerprint, why in lost.items():
            if self.stored.pop(fingerprint, None):
                self.done -= 1
            self.failed[fingerprint] = f"its record {why}"


@dataclass(frozen=True)
class Missing:
    """What of a plan is still to be run.

    Attributes:
        points: the points without a complete run, those that probably take longest first.
        stored: the others' runs, by fingerprint.
    """

    points: list[PlannedPoint]
    stored: Mapping[str, StoredRun]


def missing(plan: Plan, tracker: Tracker) -> Missing:
    """Which points of a plan a tracker does not have."""
    stored = tracker.finished([planned.fingerprint for planned in plan])
    points = [planned for planned in plan if planned.fingerprint not in stored]
    return Missing(sorted(points, key=lambda planned: -expected_moves(planned.point)), stored)


def run_point(
    planned: PlannedPoint, tracker: Tracker, threads: int | None, waiting: Callable[[], None] = lambda: None
) -> tuple[StoredRun, bool]:
    """The record of a point, and whether it had to be learned for it.

    Args:
        planned: the point.
        tracker: where results are.
        threads: cores that learn, all if None.
        waiting: is called once if another process is at this point, which is then waited for.
    """
    from rl_design_space.learning import simulate

    fingerprint = planned.fingerprint
    stored = tracker.finished([fingerprint]).get(fingerprint)
    while stored is None and not tracker.lock(fingerprint):
        waiting()
        waiting = _nothing
        time.sleep(_PATIENCE)
        stored = tracker.recorded_since(fingerprint)
    stored = stored or tracker.recorded_since(fingerprint)
    try:
        if stored:
            tracker.add_studies({fingerprint: stored}, {fingerprint: planned.studies})
            return stored, False
        return tracker.record(planned, simulate(planned.point, threads)), True
    finally:
        tracker.unlock(fingerprint)


def run_sweep(
    plan: Plan,
    tracker: Tracker,
    executor: Executor,
    watcher: Watcher,
    *,
    command: str = "",
    on_error: Literal["continue", "stop"] = "continue",
    found: Missing | None = None,
    summarised: bool = True,
) -> Outcome:
    """Run the points of a plan that the tracker does not have.

    Args:
        plan: what to run.
        tracker: where results go.
        executor: who learns.
        watcher: is told of every point that starts or ends, from several threads.
        command: that runs this sweep, for the record.
        on_error: whether a point that fails leaves the others alone, or keeps them from being begun.
        found: what `missing` says, if it was asked already.
        summarised: whether the sweep gets a summary run.
    """
    found = found or missing(plan, tracker)
    outcome = Outcome(len(plan), already=len(found.stored), stored=dict(found.stored))
    add_studies(plan, found.stored, tracker)
    if found.points:
        with summary(plan, outcome, tracker, command) if summarised else nullcontext():
            _learn(found.points, tracker, executor, watcher, outcome, on_error)
            started = time.perf_counter()
            outcome.lose(tracker.wait_for_delivery(watcher.waiting).lost)
            outcome.seconds["delivery"] = time.perf_counter() - started
    outcome.delivery = tracker.wait_for_delivery(watcher.waiting)
    return outcome


@contextmanager
def summary(plan: Plan, outcome: Outcome, tracker: Tracker, command: str) -> Iterator[None]:
    """A summary run around what happens inside, closed whatever happens: Hydra's end callbacks skip failed jobs."""
    record = tracker.open_sweep(plan, command)
    started = time.perf_counter()
    status = "KILLED"
    try:
        yield
        status = "FAILED" if outcome.failed else "FINISHED"
    finally:
        outcome.seconds["run"] = time.perf_counter() - started
        failures = {
            planned.command: outcome.failed[planned.fingerprint]
            for planned in plan
            if planned.fingerprint in outcome.failed
        }
        counts = {name: count for name, count in outcome.counts.items() if count or name == "done"}
        verdict = ", ".join(f"{count:,} {_COUNTED[name]}" for name, count in counts.items())
        record.close(SweepEnding(status, verdict, outcome.counts, failures, outcome.stored))


def add_studies(plan: Plan, stored: Mapping[str, StoredRun], tracker: Tracker) -> None:
    """Note of stored points that they belong to the studies of a plan."""
    tracker.add_studies(stored, {planned.fingerprint: planned.studies for planned in plan})


def describe_error(error: BaseException) -> str:
    """An error in one line, with the place where it was raised."""
    trace = error.__traceback__
    while trace and trace.tb_next:
        trace = trace.tb_next
    place = f" ({trace.tb_frame.f_code.co_filename}:{trace.tb_lineno})" if trace else ""
    return " ".join(f"{type(error).__name__}: {error}{place}".split())


def _learn(
    points: Sequence[PlannedPoint],
    tracker: Tracker,
    executor: Executor,
    watcher: Watcher,
    outcome: Outcome,
    on_error: Literal["continue", "stop"],
) -> None:
    learning = 0.0
    claims: set[str] = set()

    def ended(planned: PlannedPoint, result: LearningCurves | Exception, stored: StoredRun | None) -> None:
        nonlocal learning
        claims.discard(planned.fingerprint)
        if isinstance(result, Exception):
            outcome.failed[planned.fingerprint] = describe_error(result)
        else:
            outcome.done += 1
            if stored:
                outcome.stored[planned.fingerprint] = stored
            outcome.moves += float(result.total_steps.sum())
            learning += result.seconds
        watcher.ended(planned, result)

    claimed = _claimed(points, tracker, watcher, outcome, claims)
    try:
        with Recorder(tracker, ended) as recorder, closing(executor.learn(claimed)) as results:
            for planned, result in results:
                watcher.learned(planned)
                recorder.put(planned, result)
                if on_error == "stop" and (outcome.failed or isinstance(result, Exception)):
                    break
    finally:
        for fingerprint in claims:  # of points that were begun and not ended
            tracker.unlock(fingerprint)
    outcome.seconds |= {"learning": learning, "recording": recorder.seconds}


def _claimed(
    points: Sequence[PlannedPoint], tracker: Tracker, watcher: Watcher, outcome: Outcome, claims: set[str]
) -> Iterator[PlannedPoint | None]:
    """Points as they can be claimed; None while others are at those that are left."""
    left = points
    while left:
        busy = []
        for planned in left:
            if not tracker.lock(planned.fingerprint):
                busy.append(planned)
            elif stored := tracker.recorded_since(planned.fingerprint):
                tracker.unlock(planned.fingerprint)
                tracker.add_studies({planned.fingerprint: stored}, {planned.fingerprint: planned.studies})
                outcome.elsewhere += 1
                outcome.stored[planned.fingerprint] = stored
                watcher.ended(planned, stored)
            else:
                claims.add(planned.fingerprint)
                watcher.started(planned)
                yield planned
        left = busy
        if left:
            yield None


def _nothing() -> None:
    pass
