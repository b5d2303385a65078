"""What a sweep prints: its plan, or its outcome."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from rl_design_space.commands.sweep_result import result_lines
from rl_design_space.commands.terminal import (
    console,
    counted,
    duration,
    failure_table,
    outcome_line,
    pending_line,
    plan_lines,
    plan_table,
)
from rl_design_space.plan.cost import at_most, estimate
from rl_design_space.plan.plan import Plan
from rl_design_space.run.enough import enough_text
from rl_design_space.run.outcome import Outcome
from rl_design_space.run.settings import Settings
from rl_design_space.tracking.backends import seconds_to_record


@dataclass(frozen=True)
class Recorded:
    """What a store has of the points of a plan.

    Attributes:
        points: fingerprints of the points that have a complete run.
        begun: numbers of periods that are recorded of other points, by the fingerprint of the point.
        changed: numbers of points that have a run of other code only, by what was changed since.
    """

    points: Collection[str] = ()
    begun: Mapping[str, int] = field(default_factory=dict)
    changed: Mapping[str, int] = field(default_factory=dict)


def show_plan(plan: Plan, settings: Settings, recorded: Recorded, *, only_planned: bool = False) -> None:
    """Print the axes of a plan, how its points were counted, and how long the missing points will take.

    Args:
        plan: the points of the sweep.
        settings: of the command.
        recorded: what the store has of the points.
        only_planned: whether the command would run a single point without `plan=true`.
    """
    left = [planned for planned in plan if planned.fingerprint not in recorded.points]
    begun = [recorded.begun.get(planned.fingerprint, 0) for planned in left]
    threads = settings.learning_threads
    if plan.axes:
        console.print(plan_table(plan))
    for line in plan_lines(plan):
        console.print(line, markup=False, soft_wrap=True)
    if settings.shard:
        number, of = settings.shard
        console.print(f"part {number} of {of}: {counted(len(plan), 'point')}")
    points, record = [planned.point for planned in left], seconds_to_record(settings.tracking)
    expected = estimate(points, threads, record, begun)
    parts = f"learning {duration(expected.learning / threads)}, recording {duration(expected.recording / threads)}"
    about = f"about {duration(expected.total)} on {counted(threads, 'core')} ({parts})"
    console.print(f"{len(recorded.points):,} recorded already, {len(left):,} to run: {about}", soft_wrap=True)
    if asking := sum(point.task.precision is not None for point in points):
        most = estimate([at_most(point) for point in points], threads, record, begun)
        asks = "1 asks" if asking == 1 else f"{asking:,} ask"
        longest = f"{duration(most.total)} if all need task.periods_at_most"
        console.print(f"- {asks} for a precision: that is the time of task.periods, {longest}", soft_wrap=True)
    if continued := sum(map(bool, begun)):
        begin = "1 begins" if continued == 1 else f"{continued:,} begin"
        console.print(f"- {begin} with periods that are recorded", markup=False, soft_wrap=True)
    show_changed(recorded.changed)
    remedy = "give -m in place of plan=true" if only_planned and len(plan) > 1 else "leave out plan=true"
    console.print(f"nothing was run; {remedy} to run these points", markup=False)


def show_changed(changed: Mapping[str, int]) -> None:
    """Print how many points run again, and what was changed since they were recorded, see `Recorded`."""
    for what, count in changed.items():
        again = "1 runs again, because its run has" if count == 1 else f"{count:,} run again, because their runs have"
        console.print(f"- {again} other code of {what}", markup=False, soft_wrap=True)


def show_outcome(
    plan: Plan,
    outcome: Outcome,
    location: str,
    command: str,
    settings: Sequence[str] = (),
    lines: Sequence[str] | None = None,
) -> None:
    """Print the outcome of a sweep: its result, counts, failures, and pending records.

    Args:
        plan: the points of the sweep.
        outcome: of the sweep.
        location: name of the tracking store.
        command: the command line, which continues a sweep that was stopped by a failure.
        settings: overrides that choose the store.
        lines: the result of the sweep; made of its stored runs if None.
    """
    for line in result_lines(plan, outcome.stored, settings, outcome.findings.best) if lines is None else lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    if enough := enough_text(plan, outcome.stored):
        console.print(enough, markup=False, soft_wrap=True)
    console.print(outcome_line(plan, outcome, location), markup=False, soft_wrap=True)
    if outcome.failed:
        console.print(failure_table(plan, outcome.failed))
        if outcome.counts["left"]:
            console.print(f"stopped at the first failure; to continue: {command}", markup=False, soft_wrap=True)
    show_pending(outcome, location)


def show_pending(outcome: Outcome, location: str) -> None:
    """Print how many records are pending, if any."""
    if outcome.delivery.pending:
        console.print(pending_line(outcome.delivery, location), markup=False, soft_wrap=True)
    if outcome.delivery.note:
        console.print(outcome.delivery.note, markup=False, soft_wrap=True)
