"""Estimates of how long design points take to learn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from rl_design_space.design import DesignPoint, cell_count, stages_of
from rl_design_space.plan.step_cost import relative_cost

#: Steps per goal until it is found and the way to it is learned: _FIRST · cells^_GROWTH. Steps per goal and trial after
#: that: _OVER · the mean distance between two cells. Fitted to Table 4; other choices change it by a factor of about 2.
_FIRST, _GROWTH, _OVER = 2.0, 1.47, 1.5
#: Seconds per step of Q-learning (docs/performance.md), per point beside its steps, and per start of the program.
_STEP, _POINT, _START = 7e-9, 0.005, 2.0


@dataclass(frozen=True)
class Estimate:
    """How long points take.

    Attributes:
        learning, recording: seconds of all threads together that learn, and that record.
        total: seconds until all is recorded.
    """

    learning: float = 0.0
    recording: float = 0.0
    total: float = 0.0


def expected_steps(point: DesignPoint, begun: int = 0) -> float:
    """Return the approximate number of steps of a point, over all trials and periods.

    It is accurate enough to start with the longest points and to estimate when a sweep ends.

    Args:
        point: the design point.
        begun: number of its periods that have been learned.
    """
    if stages := stages_of(point):
        return sum(expected_steps(stage.point) for stage in stages)
    task, cells = point.task, cell_count(point.world)
    distance = sum(point.world.shape) / 4
    period: float = task.goals * (_FIRST * cells**_GROWTH + _OVER * distance * task.trials)
    return max(0, task.periods - begun) * min(period, task.trials * task.max_steps)


def expected_work(point: DesignPoint, begun: int = 0) -> float:
    """Return the approximate time of a point, in steps of Q-learning: its steps, by what each costs its learner.

    Args:
        point: the design point.
        begun: number of its periods that have been learned.
    """
    if stages := stages_of(point):
        return sum(expected_work(stage.point) for stage in stages)
    return expected_steps(point, begun) * relative_cost(point)


def at_most(point: DesignPoint) -> DesignPoint:
    """Return a point with the most periods that it may need."""
    task = point.task
    return point if task.precision is None else replace(point, task=task.with_periods(task.periods_at_most))


def estimate(points: Sequence[DesignPoint], threads: int, record: float, begun: Sequence[int] = ()) -> Estimate:
    """Return approximately how long these points take to learn and record.

    Args:
        points: the points.
        threads: number of threads that learn; one more thread records.
        record: seconds to record a point.
        begun: how many periods of each point have been learned; none if it is empty.
    """
    steps = [expected_work(*each) for each in zip(points, begun or [0] * len(points), strict=True)]
    if not steps:
        return Estimate()
    learning, recording = sum(steps) * _STEP + len(steps) * _POINT, len(steps) * record
    longest = max((learning + recording) / threads, recording, max(steps) * _STEP / threads)
    return Estimate(learning, recording, _START + longest)
