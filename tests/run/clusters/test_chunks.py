"""Chunks of points on a cluster that is played: taken late, learned again when a worker dies, closed at the end."""

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
from rl_design_space.run.clusters.worker import Failure, learn_chunk, prepared


def point(size: int) -> PlannedPoint:
    made = DesignPoint(world=Torus(size=size), task=Task(periods=2, trials=3))
    return PlannedPoint.of(made, {}, (f"{size}",))


@dataclass
class Played:
    """A cluster whose workers learn when they are waited for; some die of points of certain sizes."""

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


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "_MOMENT", 0.001)


def learned(cluster: Played, points: list[PlannedPoint | None], size: int | None = None) -> dict[int, object]:
    results = list(learn_in_chunks(cluster, iter(points), size))
    assert cluster.closed == 1
    assert len({planned.fingerprint for planned, _ in results}) == len(results), "a point came twice"
    return {planned.point.world.size: result for planned, result in results}


@pytest.mark.parametrize("size", [None, 1, 3, 100])
def test_every_point_comes_back_as_if_it_had_been_learned_here(size: int | None):
    points = [point(size) for size in range(4, 24)]
    found = learned(Played(), points, size)
    assert set(found) == set(range(4, 24))
    for planned in points:
        curves, expected = found[planned.point.world.size], simulate(planned.point)
        assert isinstance(curves, LearningCurves)
        assert np.array_equal(curves.steps, expected.steps)


def test_chunks_are_as_large_as_asked_for():
    cluster = Played()
    learned(cluster, [point(size) for size in range(4, 11)], 3)
    assert cluster.submitted == [[4, 5, 6], [7, 8, 9], [10]]


def test_chunks_grow_but_long_points_stay_alone():
    short, long = Played(), Played()
    learned(short, [point(size) for size in range(4, 60)])
    sizes = [len(chunk) for chunk in short.submitted]
    assert sizes[:4] == [1, 1, 1, 1]
    assert max(sizes) > 4
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(chunks, "expected_moves", lambda _: 1e9)
        learned(long, [*(point(size) for size in range(4, 40))])
    assert {len(chunk) for chunk in long.submitted} == {1}


def test_points_are_taken_no_earlier_than_workers_can_begin():
    taken: list[int] = []

    def points() -> Iterator[PlannedPoint]:
        for size in range(4, 40):
            taken.append(size)
            yield point(size)

    cluster = Played()
    for ended, _ in enumerate(learn_in_chunks(cluster, points(), 1), 1):
        assert len(taken) <= ended + 2 * cluster.workers + 1
    assert ended == len(range(4, 40))


def test_nothing_at_the_moment_is_not_the_end():
    assert set(learned(Played(), [None, point(4), None, None, point(5), None])) == {4, 5}


def test_when_a_worker_dies_its_points_are_learned_elsewhere():
    found = learned(Played(deadly={5: 1}), [point(4), point(5)], 2)
    assert {size: type(curves) for size, curves in found.items()} == {4: LearningCurves, 5: LearningCurves}


def test_a_point_that_kills_every_worker_is_given_up_and_the_others_are_not():
    cluster = Played(deadly={5: 99})
    found = learned(cluster, [point(size) for size in (4, 5, 6)], 3)
    assert isinstance(found[5], RuntimeError)
    assert "3 workers died while they learned it" in str(found[5])
    assert isinstance(found[4], LearningCurves)
    assert isinstance(found[6], LearningCurves)
    assert cluster.submitted.count([5]) == 3


def test_closing_closes_the_cluster():
    cluster = Played()
    results = learn_in_chunks(cluster, iter([point(4), point(5)]), 1)
    next(results)
    results.close()
    assert cluster.closed == 1


class Unsendable(Torus):
    """A world that cannot leave its process."""

    def __reduce__(self) -> tuple:
        raise TypeError("made of glass")


def test_a_point_that_cannot_be_sent_fails_alone():
    glass = PlannedPoint.of(DesignPoint(world=Unsendable(size=9), task=Task(periods=1)), {}, ("9",))
    found = learned(Played(), [point(4), glass, point(5)], 1)
    assert isinstance(found[9], TypeError)
    assert isinstance(found[5], LearningCurves)


class Broken(Torus):
    """A world that fails on the worker."""

    def next_cell(self):
        raise ArithmeticError("no luck")


def test_a_point_that_fails_on_a_worker_comes_back_in_words():
    broken = PlannedPoint.of(DesignPoint(world=Broken(size=4), task=Task(periods=1)), {})
    fine = PlannedPoint.of(DesignPoint(world=Torus(size=4), task=Task(periods=1, trials=1)), {})
    first, second = learn_chunk([prepared(broken), prepared(fine)], KERNEL_VERSION)
    assert isinstance(first, Failure)
    assert isinstance(second, LearningCurves)
    error = pickle.loads(pickle.dumps(first)).error()
    assert type(error).__name__ == "ArithmeticError"
    assert str(error).startswith("no luck (")


def test_a_worker_with_another_version_of_an_own_component_says_so():
    planned = PlannedPoint.of(DesignPoint(world=Torus(size=4), task=Task(periods=1, trials=1)), {})
    (failure,) = learn_chunk([prepared(replace(planned, fingerprint="0" * 64))], KERNEL_VERSION)
    assert isinstance(failure, Failure)
    assert "another version of an own component" in failure.text


def test_a_worker_with_another_algorithm_learns_nothing():
    with pytest.raises(RuntimeError, match="learns by version 1 of the algorithm, not by 2"):
        learn_chunk([], 2)
