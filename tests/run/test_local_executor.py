"""The local executor: points are taken when they can start, all threads work to the end, and closing stops them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves, simulate, simulation
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.local_executor import LocalExecutor


def point(size: int = 4, periods: int = 3) -> PlannedPoint:
    return PlannedPoint.of(DesignPoint(world=Torus(size=size), task=Task(periods=periods, trials=3)), {}, (f"{size}",))


def executor(threads: int) -> LocalExecutor:
    return LocalExecutor(threads, poll=0.01, join_timeout=1)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_result_equals_that_of_simulate(threads: int):
    points = [point(size) for size in range(4, 12)]
    results = list(executor(threads).learn(iter(points)))
    assert sorted(planned.point.world.size for planned, _ in results) == list(range(4, 12))
    for planned, curves in results:
        assert isinstance(curves, LearningCurves)
        assert np.array_equal(curves.steps, simulate(planned.point).steps)


def test_no_points_give_no_results():
    assert list(executor(3).learn(iter([]))) == []


def test_points_are_taken_only_when_they_can_start():
    # Taking a point locks it, and other processes wait for locked points.
    taken = []

    def points() -> Iterator[PlannedPoint]:
        for size in range(4, 40):
            taken.append(size)
            yield point(size)

    threads = 2
    with closing(executor(threads).learn(points())) as results:
        for ended, _ in enumerate(results, 1):
            # Queued results and points in progress.
            assert len(taken) <= ended + 2 * threads + 2 * threads
    assert ended == len(range(4, 40))


def test_none_is_not_the_end_of_the_points():
    given = [point(4), None, None, point(5), None]
    assert len(list(executor(2).learn(iter(given)))) == 2


def test_threads_without_a_point_help_with_those_in_progress(monkeypatch: pytest.MonkeyPatch):
    # A thread waits at the first share of a point until another thread has joined: alone it would time out.
    both, helpers = threading.Barrier(2, timeout=30), set()
    work = simulation.Learning._work

    def together(self: simulation.Learning) -> None:
        helpers.add(threading.current_thread().name)
        both.wait(timeout=30)
        work(self)

    monkeypatch.setattr(simulation.Learning, "_work", together)
    ((_, curves),) = executor(2).learn(iter([point(periods=500)]))
    assert isinstance(curves, LearningCurves)
    assert len(helpers) == 2
    monkeypatch.undo()
    assert np.array_equal(curves.steps, simulate(point(periods=500).point).steps)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_failed_point_is_a_result(threads: int, monkeypatch: pytest.MonkeyPatch):
    work = simulation.Learning._work

    def fail(self: simulation.Learning) -> None:
        if self._point.world.size == 5:
            raise ArithmeticError("no luck")
        work(self)

    monkeypatch.setattr(simulation.Learning, "_work", fail)
    results = {planned.name: result for planned, result in executor(threads).learn(map(point, (4, 5, 6)))}
    assert isinstance(results["5"], ArithmeticError)
    assert isinstance(results["4"], LearningCurves)
    assert isinstance(results["6"], LearningCurves)


def test_an_error_of_the_points_iterator_is_raised():
    def points() -> Iterator[PlannedPoint]:
        yield point(4)
        raise ConnectionError("the store is gone")

    with pytest.raises(ConnectionError, match="the store is gone"):
        list(executor(2).learn(points()))


def test_closing_leaves_no_thread_behind():
    def endless() -> Iterator[PlannedPoint]:
        while True:
            yield point(periods=50)

    before = threading.active_count()
    with closing(executor(3).learn(endless())) as results:
        next(results)
        assert threading.active_count() == before + 3
    assert threading.active_count() == before


@pytest.mark.parametrize(("threads", "text"), [(1, "1 thread"), (8, "8 threads")])
def test_describe_returns_the_number_of_threads(threads: int, text: str):
    assert LocalExecutor(threads).describe() == text
