"""Memory of learning grows with the cells of the world and the running periods, not with the steps."""

from __future__ import annotations

import tracemalloc
from contextlib import nullcontext
from dataclasses import replace

import pytest

from rl_design_space.design import DesignPoint, Direction, Task, Torus
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.memory import check_memory
from rl_design_space.learning.simulation import Learning

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


@pytest.mark.parametrize(
    ("task", "gigabytes", "message"),
    [
        (Task(periods=10**9), 500, "task.periods=1000000000: 1,000,000,000 periods of 100 trials need 660 GB"),
        (Task(trials=10**12, periods=2), 500, "task.trials=1000000000000: "),
        (Task(periods=10**6), 1, None),
    ],
)
def test_results_that_cannot_fit_into_memory_are_refused(task: Task, gigabytes: int, message: str | None):
    with pytest.raises(ConfigError, match=message) if message else nullcontext():
        check_memory(task, gigabytes * 1e9)


def test_a_point_that_cannot_fit_is_refused_before_anything_is_allocated():
    with pytest.raises(ConfigError, match="and this machine has"):
        Learning(replace(POINT, task=Task(periods=10**15)))
