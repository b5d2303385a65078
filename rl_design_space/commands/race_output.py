"""What a race prints before and after it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rl_design_space.commands.sweep_output import Recorded, show_changed
from rl_design_space.commands.sweep_result import mattered_lines, more_lines
from rl_design_space.commands.terminal import console, counted, duration, plan_lines, plan_table
from rl_design_space.plan.cost import estimate
from rl_design_space.plan.plan import Plan
from rl_design_space.run.settings import Settings
from rl_design_space.tracking.backends import seconds_to_record

if TYPE_CHECKING:
    from rl_design_space.analysis.race import Look
    from rl_design_space.commands.race_result import RaceResult
    from rl_design_space.tracking.tracker import StoredRun


def show_plan(plan: Plan, begin: Plan, looks: Sequence[Look], settings: Settings, recorded: Sequence[Recorded]) -> None:
    """Print the axes of a race, how its points were counted, and bounds of what it takes.

    Args:
        plan: the points with all periods.
        begin: the points with the periods of the first look.
        looks: when points are compared.
        settings: of the command.
        recorded: what the store has of both plans, first that of `begin`.
    """
    if plan.axes:
        console.print(plan_table(plan))
    for line in plan_lines(plan):
        console.print(line, markup=False, soft_wrap=True)
    counts = ", ".join(f"{look.periods:,}" for look in looks)
    what = "those that are worse beyond doubt stop"
    if len(looks) == 1:
        what = "none stops early, as task.periods is not above hydra.sweeper.first"
    console.print(f"compared after {counts} periods; {what}", soft_wrap=True)
    threads, record = settings.learning_threads, seconds_to_record(settings.tracking)
    for bound, part, found, records in zip(("least", "most"), (begin, plan), recorded, (1, len(looks)), strict=True):
        left = [planned for planned in part if planned.fingerprint not in found.points]
        begun = [found.begun.get(planned.fingerprint, 0) for planned in left]
        expected = estimate([planned.point for planned in left], threads, records * record, begun)
        console.print(
            f"at {bound} {part[0].point.task.periods:,} periods of each point: {len(found.points):,} recorded already, "
            f"{len(left):,} to run: about {duration(expected.total)} on {counted(threads, 'core')}",
            soft_wrap=True,
        )
        show_changed(found.changed)
    console.print("nothing was run; leave out plan=true to run the race", markup=False)


def result_lines(result: RaceResult, stored: Mapping[str, StoredRun], settings: Sequence[str]) -> list[str]:
    """Return the result of a race: what it took, the best, what mattered, and the commands for more.

    Args:
        result: of the race.
        stored: the runs of its points, by fingerprint.
        settings: overrides that choose the store, for the commands.
    """
    *before, size = result.lines
    return [
        *before,
        f"{size}:",
        *result.listed,
        *mattered_lines(result.plan, stored),
        *more_lines(result.plan, settings, result.name),
    ]
