"""Chunks of points: how many are taken at a time, and what becomes of them on a cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Hashable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from time import sleep
from typing import Protocol

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_moves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.clusters.worker import Failure, prepared
from rl_design_space.run.executor import Learned

#: Chunks a worker: one that it learns, and one that it need not wait for when it is done.
_IN_FLIGHT = 2
#: About a second of learning, and points that are enough in any case: whoever waits for the last chunk waits briefly.
_MOVES, _POINTS = 1.4e8, 64
#: Workers that may die of a point before it is given up.
_ATTEMPTS = 3
#: Seconds between two looks at the points when no result comes.
_MOMENT = 0.2

Results = Sequence[LearningCurves | Failure]


class Cluster(Protocol):
    """Workers that learn chunks of prepared points."""

    @property
    def workers(self) -> int:
        """How many chunks are learned at the same time, at the moment."""
        ...

    def submit(self, points: list[bytes]) -> Hashable:
        """Have `learn_chunk` called with these points; tasks submitted first begin first."""
        ...

    def wait(self, seconds: float) -> Iterable[tuple[Hashable, Results | None]]:
        """Some tasks that are done, as soon as there are any, and their results; None if the worker died.

        Raises:
            ConfigError: the cluster cannot be used, or is gone.
        """
        ...

    def close(self) -> None:
        """Give up what is under way, and end what was started."""
        ...


def learn_in_chunks(
    cluster: Cluster, points: Iterator[PlannedPoint | None], size: int | None
) -> Generator[Learned, None, None]:
    """Learn points on a cluster, which is closed at the end; see `Executor.learn`.

    Args:
        cluster: where.
        points: None means that there is nothing at the moment.
        size: points a chunk; if None, few enough that all workers stay busy to the end.
    """
    with closing(cluster):
        yield from _Learning(cluster, points, size).run()


@dataclass
class _Chunk:
    points: list[PlannedPoint]
    pickled: list[bytes]
    deaths: int = 0


class _Learning:
    """The chunks that are under way, and those that have to be learned again."""

    def __init__(self, cluster: Cluster, points: Iterator[PlannedPoint | None], size: int | None) -> None:
        self._cluster = cluster
        self._points = points
        self._size = size
        self._under_way: dict[Hashable, _Chunk] = {}
        self._again: deque[_Chunk] = deque()
        self._taken = 0
        self._ended = False

    def run(self) -> Generator[Learned, None, None]:
        yield from self._fill()
        while self._under_way or not self._ended:
            results: list[Learned] = []
            if self._under_way:
                for task, curves in self._cluster.wait(_MOMENT):
                    results += self._done(self._under_way.pop(task), curves)
            else:
                sleep(_MOMENT)
            # Workers get their next chunk before anybody spends time on the results.
            results += self._fill()
            yield from results

    def _fill(self) -> list[Learned]:
        """Keep all workers busy; points that cannot be sent are what is returned."""
        failed: list[Learned] = []
        most = _IN_FLIGHT * max(self._cluster.workers, 1)
        while len(self._under_way) < most:
            chunk = self._again.popleft() if self._again else self._take(most, failed)
            if not chunk.points:
                break
            self._under_way[self._cluster.submit(chunk.pickled)] = chunk
        return failed

    def _take(self, in_flight: int, failed: list[Learned]) -> _Chunk:
        """The next points. The first chunks are small: so many workers share however few points there are."""
        most, moves = self._size or min(_POINTS, 1 + self._taken // in_flight), 0.0
        chunk = _Chunk([], [])
        while len(chunk.points) < most and (self._size or moves < _MOVES):
            planned = self._next()
            if planned is None:
                break
            self._taken += 1
            try:
                chunk.pickled.append(prepared(planned))
            except Exception as error:
                failed.append((planned, error))
                continue
            chunk.points.append(planned)
            moves += expected_moves(planned.point)
        return chunk

    def _next(self) -> PlannedPoint | None:
        if self._ended:
            return None
        try:
            return next(self._points)
        except StopIteration:
            self._ended = True
            return None

    def _done(self, chunk: _Chunk, results: Results | None) -> Iterator[Learned]:
        if results is not None:
            for planned, result in zip(chunk.points, results, strict=True):
                yield planned, result.error() if isinstance(result, Failure) else result
        elif len(chunk.points) > 1:
            # Each alone: one of them may be what the worker died of.
            self._again += [_Chunk([one], [pickled]) for one, pickled in zip(chunk.points, chunk.pickled, strict=True)]
        elif chunk.deaths + 1 < _ATTEMPTS:
            self._again.append(_Chunk(chunk.points, chunk.pickled, chunk.deaths + 1))
        else:
            reason = f"{_ATTEMPTS} workers died while they learned it; it may need more memory than they have"
            yield chunk.points[0], RuntimeError(reason)
