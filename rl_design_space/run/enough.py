"""How many periods the points of a plan needed that ask for a precision."""

from __future__ import annotations

from collections.abc import Mapping

from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.tracker import Enough, StoredRun


def enough_text(plan: Plan, stored: Mapping[str, StoredRun]) -> str:
    """Return how many points reached the precision that they ask for, with how many periods; empty if none asks.

    Args:
        plan: the points.
        stored: their runs, by fingerprint.
    """
    runs = [stored.get(planned.fingerprint) for planned in plan if planned.point.task.precision is not None]
    found: list[Enough] = [run.enough for run in runs if run and run.enough]
    if not found:
        return ""
    periods = sorted(each.periods for each in found)
    reached = sum(each.is_reached for each in found)
    span = f"{periods[0]:,}" if periods[0] == periods[-1] else f"{periods[0]:,} to {periods[-1]:,}"
    points = f"{len(found):,} point{'' if len(found) == 1 else 's'}"
    text = f"precision reached by {reached:,} of {points}, with {span} periods"
    return text if reached == len(found) else f"{text}; the others have task.periods_at_most"
