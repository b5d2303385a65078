"""Chunks of points on a fake cluster: taken late, retried when a worker dies, closed at the end."""

from __future__ import annotations

import pickle
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.clusters import chunks
from rl_design_space.run.clusters.chunks import Results, learn_in_chunks
from rl_design_space.run.clusters.worker import Failure, learn_chunk, pickled


def point(size: int) -> PlannedPoint:
    made = DesignPoint(world=Torus(size=size), task=Task(periods=2, trials=3))
    return PlannedPoint.of(made, {}, (f"{size}",))


@dataclass
class FakeCluster:
    """A cluster that learns in `wait`; its workers die while they learn points of certain sizes."""

    workers: int = 2
    deadly: dict[int, int] = field(default_factory=dict)
    waiting: dict[int, list[bytes]] = field(default_factory=dict)
    submitted: list[list[int]] = field(default_factory=list)
    closed: int = 0

    def submit(self, points: list[bytes]) -> Hashable:
        sizes = [pickle.loads(one)[1].world.size for one in points]
        self.submitted.append(sizes)
        self.waiting[len(self.submitted)] = points
        return len(self.submitted)

    def wait(self, seconds: float) -> list[tuple[Hashable, Results | None]]:
        task = min(self.waiting)
        points = self.waiting.pop(task)
        for one in points:
            size = pickle.loads(one)[1].world.size
            if self.deadly.get(size, 0):
                self.deadly[size] -= 1
                return [(task, None)]
        return [(task, learn_chunk(points, KERNEL_VERSION))]

    def close(self) -> None:
        self.closed += 1


def learned(cluster: FakeCluster, points: list[PlannedPoint | None], size: int | None = None) -> dict[int, object]:
    results = list(learn_in_chunks(cluster, iter(points), size, poll=0.001))
    assert cluster.closed == 1
    assert len({planned.fingerprint for planned, _ in results}) == len(results), "a point came twice"
    return {planned.point.world.size: result for planned, result in results}


@pytest.mark.parametrize("size", [None, 1, 3, 100])
def test_every_result_equals_that_of_simulate(size: int | None):
    points = [point(size) for size in range(4, 24)]
    found = learned(FakeCluster(), points, size)
    assert set(found) == set(range(4, 24))
    for planned in points:
        curves, expected = found[planned.point.world.size], simulate(planned.point)
        assert isinstance(curves, LearningCurves)
        assert np.array_equal(curves.steps, expected.steps)


def test_chunks_have_the_given_size():
    cluster = FakeCluster()
    learned(cluster, [point(size) for size in range(4, 11)], 3)
    assert cluster.submitted == [[4, 5, 6], [7, 8, 9], [10]]


def test_chunks_of_short_points_grow_and_long_points_stay_alone():
    short, long = FakeCluster(), FakeCluster()
    learned(short, [point(size) for size in range(4, 60)])
    sizes = [len(chunk) for chunk in short.submitted]
    assert sizes[:4] == [1, 1, 1, 1]
    assert max(sizes) > 4
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chunks, "expected_work", lambda *_: 1e9)
        learned(long, [*(point(size) for size in range(4, 40))])
    assert {len(chunk) for chunk in long.submitted} == {1}


def test_points_are_taken_only_when_workers_can_start():
    taken: list[int] = []

    def points() -> Iterator[PlannedPoint]:
        for size in range(4, 40):
            taken.append(size)
            yield point(size)

    cluster = FakeCluster()
    for ended, _ in enumerate(learn_in_chunks(cluster, points(), 1), 1):
        assert len(taken) <= ended + 2 * cluster.workers + 1
    assert ended == len(range(4, 40))


def test_none_is_not_the_end_of_the_points():
    assert set(learned(FakeCluster(), [None, point(4), None, None, point(5), None])) == {4, 5}


def test_points_of_a_dead_worker_are_retried():
    found = learned(FakeCluster(deadly={5: 1}), [point(4), point(5)], 2)
    assert {size: type(curves) for size, curves in found.items()} == {4: LearningCurves, 5: LearningCurves}


def test_a_point_that_kills_every_worker_fails_alone():
    cluster = FakeCluster(deadly={5: 99})
    found = learned(cluster, [point(size) for size in (4, 5, 6)], 3)
    assert isinstance(found[5], RuntimeError)
    assert "3 workers died while they learned this point" in str(found[5])
    assert isinstance(found[4], LearningCurves)
    assert isinstance(found[6], LearningCurves)
    assert cluster.submitted.count([5]) == 3


def test_closing_the_results_closes_the_cluster():
    cluster = FakeCluster()
    results = learn_in_chunks(cluster, iter([point(4), point(5)]), 1)
    next(results)
    results.close()
    assert cluster.closed == 1


class Unsendable(Torus):
    """A world that cannot be pickled."""

    def __reduce__(self) -> tuple:
        raise TypeError("made of glass")


def test_a_point_that_cannot_be_pickled_fails_alone():
    glass = PlannedPoint.of(DesignPoint(world=Unsendable(size=9), task=Task(periods=1)), {}, ("9",))
    found = learned(FakeCluster(), [point(4), glass, point(5)], 1)
    assert isinstance(found[9], TypeError)
    assert isinstance(found[5], LearningCurves)


class Broken(Torus):
    """A world that fails on the worker."""

    def next_cell(self):
        raise ArithmeticError("no luck")


def test_an_error_on_a_worker_is_returned_as_text():
    broken = PlannedPoint.of(DesignPoint(world=Broken(size=4), task=Task(periods=1)), {})
    fine = PlannedPoint.of(DesignPoint(world=Torus(size=4), task=Task(periods=1, trials=1)), {})
    first, second = learn_chunk([pickled(broken), pickled(fine)], KERNEL_VERSION)
    assert isinstance(first, Failure)
    assert isinstance(second, LearningCurves)
    error = pickle.loads(pickle.dumps(first)).error()
    assert type(error).__name__ == "ArithmeticError"
    assert str(error).startswith("no luck (")


def test_a_worker_with_another_version_of_a_user_component_fails():
    planned = PlannedPoint.of(DesignPoint(world=Torus(size=4), task=Task(periods=1, trials=1)), {})
    (failure,) = learn_chunk([pickled(replace(planned, fingerprint="0" * 64))], KERNEL_VERSION)
    assert isinstance(failure, Failure)
    assert "another version of a user component" in failure.text


def test_a_worker_with_another_kernel_version_refuses_to_learn():
    with pytest.raises(RuntimeError, match="has version 1 of the learning algorithm, not 2"):
        learn_chunk([], 2)


def test_a_point_continues_a_result_of_fewer_periods():
    short = point(4)
    (begun,) = learn_chunk([pickled(short)], KERNEL_VERSION)
    (found,) = learn_chunk([pickled(short.with_periods(9, begun))], KERNEL_VERSION)
    assert found.seconds > begun.seconds
    assert np.array_equal(found.steps, simulate(short.with_periods(9).point).steps)
