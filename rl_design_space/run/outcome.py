"""The outcome of a sweep, and the summary run that records it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from rl_design_space.plan.plan import Plan
from rl_design_space.run.enough import enough_text
from rl_design_space.tracking.tracker import DeliveryStatus, Findings, StoredRun, SweepEnding, Tracker

#: How the verdict of a sweep words each of its counts.
_COUNT_LABELS = {
    "already": "recorded before",
    "done": "learned now",
    "elsewhere": "by another process",
    "failed": "failed",
    "left": "not run",
}


@dataclass
class Outcome:
    """Numbers of points by status, their runs, and the time that the sweep took.

    Attributes:
        points: number of points in the plan.
        already: points that were recorded before the sweep started.
        done: points learned and recorded by this sweep.
        elsewhere: points recorded by another process during the sweep.
        failed: error messages, by the fingerprint of the point.
        stored: the runs of all other points, by fingerprint.
        delivery: which records are still pending, or cannot be stored.
        steps: steps learned by this sweep.
        seconds: time by activity; `learning` is the sum over all threads.
        findings: what the sweep found out, beside the results of its points.
    """

    points: int = 0
    already: int = 0
    done: int = 0
    elsewhere: int = 0
    failed: dict[str, str] = field(default_factory=dict)
    stored: dict[str, StoredRun] = field(default_factory=dict)
    delivery: DeliveryStatus = field(default_factory=DeliveryStatus)
    steps: float = 0.0
    seconds: dict[str, float] = field(default_factory=dict)
    findings: Findings = field(default_factory=Findings)

    @property
    def counts(self) -> dict[str, int]:
        """Numbers of points by status; the keys are recorded with the summary run."""
        left = self.points - self.already - self.done - self.elsewhere - len(self.failed)
        return {
            "already": self.already,
            "done": self.done,
            "elsewhere": self.elsewhere,
            "failed": len(self.failed),
            "left": left,
        }

    def count_lost(self, lost: Mapping[str, str]) -> None:
        """Count points whose records cannot be stored as failed.

        Args:
            lost: the reasons, by fingerprint.
        """
        for fingerprint, reason in lost.items():
            if self.stored.pop(fingerprint, None):
                self.done -= 1
            self.failed[fingerprint] = lost_record(reason)


class PointFailedError(Exception):
    """The learning of a point failed; the message is that of its error, which is the cause."""


@contextmanager
def summary_run(plan: Plan, outcome: Outcome, tracker: Tracker, command: str) -> Iterator[None]:
    """Open a summary run, and close it whatever happens inside: Hydra's end callbacks skip failed jobs.

    Args:
        plan: the points of the sweep.
        outcome: read when the summary run is closed.
        tracker: records the summary run.
        command: the command line of the sweep.
    """
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
            for planned in outcome.findings.plan or plan
            if planned.fingerprint in outcome.failed
        }
        counts = {name: count for name, count in outcome.counts.items() if count or name == "done"}
        verdict = ", ".join(f"{count:,} {_COUNT_LABELS[name]}" for name, count in counts.items())
        if enough := enough_text(plan, outcome.stored):
            verdict += f"; {enough}"
        record.close(SweepEnding(status, verdict, outcome.counts, failures, outcome.stored, outcome.findings))


def lost_record(reason: str) -> str:
    """Return the message of a point whose record cannot be stored."""
    return f"its record cannot be stored: {reason}"


def describe_error(error: BaseException) -> str:
    """Return an error as one line, with the file and line that raised it."""
    if isinstance(error, PointFailedError):
        return str(error)
    trace = error.__traceback__
    while trace and trace.tb_next:
        trace = trace.tb_next
    place = f" ({trace.tb_frame.f_code.co_filename}:{trace.tb_lineno})" if trace else ""
    return " ".join(f"{type(error).__name__}: {error}{place}".split())
