"""The local executor: points are taken when they can begin, all threads work to the end, and closing stops them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves, simulate, simulation
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run import executor
from rl_design_space.run.executor import LocalExecutor


def point(size: int = 4, periods: int = 3) -> PlannedPoint:
    return PlannedPoint.of(DesignPoint(world=Torus(size=size), task=Task(periods=periods, trials=3)), {}, (f"{size}",))


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executor, "_MOMENT", 0.01)
    monkeypatch.setattr(executor, "_PATIENCE", 1)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_point_is_learned_as_if_it_were_alone(threads: int):
    points = [point(size) for size in range(4, 12)]
    results = list(LocalExecutor(threads).learn(iter(points)))
    assert sorted(planned.point.world.size for planned, _ in results) == list(range(4, 12))
    for planned, curves in results:
        assert isinstance(curves, LearningCurves)
        assert np.array_equal(curves.steps, simulate(planned.point).steps)


def test_without_points_there_is_nothing_to_learn():
    assert list(LocalExecutor(3).learn(iter([]))) == []


def test_points_are_taken_only_when_they_can_begin():
    # Whoever gives them claims them, and others wait for what is claimed.
    taken = []

    def points() -> Iterator[PlannedPoint]:
        for size in range(4, 40):
            taken.append(size)
            yield point(size)

    threads = 2
    with closing(LocalExecutor(threads).learn(points())) as results:
        for ended, _ in enumerate(results, 1):
            # Those that have ended and wait to be fetched, and those under way.
            assert len(taken) <= ended + 2 * threads + 2 * threads
    assert ended == len(range(4, 40))


def test_nothing_at_the_moment_is_not_the_end():
    given = [point(4), None, None, point(5), None]
    assert len(list(LocalExecutor(2).learn(iter(given)))) == 2


def test_threads_without_a_point_help_the_others(monkeypatch: pytest.MonkeyPatch):
    # A thread that has joined a point waits at the first share until another has joined, too: alone it would never end.
    both, helpers = threading.Barrier(2), set()
    work = simulation.Learning._work

    def together(self: simulation.Learning) -> None:
        helpers.add(threading.current_thread().name)
        both.wait(timeout=30)
        work(self)

    monkeypatch.setattr(simulation.Learning, "_work", together)
    ((_, curves),) = LocalExecutor(2).learn(iter([point(periods=500)]))
    assert isinstance(curves, LearningCurves)
    assert len(helpers) == 2
    monkeypatch.undo()
    assert np.array_equal(curves.steps, simulate(point(periods=500).point).steps)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_point_that_fails_is_a_result(threads: int, monkeypatch: pytest.MonkeyPatch):
    work = simulation.Learning._work

    def fail(self: simulation.Learning) -> None:
        if self._point.world.size == 5:
            raise ArithmeticError("no luck")
        work(self)

    monkeypatch.setattr(simulation.Learning, "_work", fail)
    results = {planned.name: result for planned, result in LocalExecutor(threads).learn(map(point, (4, 5, 6)))}
    assert isinstance(results["5"], ArithmeticError)
    assert isinstance(results["4"], LearningCurves)
    assert isinstance(results["6"], LearningCurves)


def test_an_error_of_who_gives_the_points_ends_everything():
    def points() -> Iterator[PlannedPoint]:
        yield point(4)
        raise ConnectionError("the store is gone")

    with pytest.raises(ConnectionError, match="the store is gone"):
        list(LocalExecutor(2).learn(points()))


def test_closing_leaves_no_thread_behind():
    def endless() -> Iterator[PlannedPoint]:
        while True:
            yield point(periods=50)

    before = threading.active_count()
    with closing(LocalExecutor(3).learn(endless())) as results:
        next(results)
        assert threading.active_count() == before + 3
    assert threading.active_count() == before


@pytest.mark.parametrize(("threads", "told"), [(1, "1 thread"), (8, "8 threads")])
def test_who_learns_is_told(threads: int, told: str):
    assert LocalExecutor(threads).describe() == told
