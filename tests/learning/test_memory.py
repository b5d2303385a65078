"""Memory of learning grows with the cells of the world and the running periods, not with the steps."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

from rl_design_space.design import DesignPoint, Direction, Task, Torus
from rl_design_space.learning import simulate

POINT = DesignPoint(task=Task(goals=1, trials=50, periods=20), world=Torus(size=20), representation=Direction())


def peak(point: DesignPoint) -> int:
    """Return the peak memory of learning a point in bytes, after compilation."""
    simulate(point, threads=1)
    tracemalloc.start()
    try:
        simulate(point, threads=1)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_more_steps_need_no_more_memory():
    few, many = (replace(POINT, task=replace(POINT.task, max_steps=cap)) for cap in (50, 5000))
    assert simulate(many).total_steps.sum() > 5 * simulate(few).total_steps.sum()
    assert peak(many) < 1.05 * peak(few)


def test_more_periods_than_lanes_need_memory_for_their_results_only():
    # Five bytes a trial, and start, goal and generator state: less than 100 bytes a period.
    once, again = (replace(POINT, task=replace(POINT.task, trials=1, periods=periods)) for periods in (1000, 3000))
    assert peak(again) < peak(once) + 2000 * 150


def test_a_large_world_stays_within_its_bounds():
    large = replace(POINT, world=Torus(size=100), task=Task(goals=3, trials=1, periods=30))
    q_matrix = 3 * 100 * 100 * 4 * 8
    assert peak(large) < 10 * q_matrix
