"""Learn points on a cluster in chunks: choose their sizes, and retry the points of workers that die."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Hashable, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from time import sleep
from typing import Protocol

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.cost import expected_work
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.clusters.worker import Failure, pickled
from rl_design_space.run.executor import PointResult

#: Chunks per worker: one that it learns, and one that is ready when it is done.
_IN_FLIGHT = 2
#: Maximum size of a chunk, in steps (about a second of learning) and in points: the last chunk ends soon.
_MAX_STEPS, _MAX_POINTS = 1.4e8, 64
#: Number of workers that may die while they learn a point before the point fails.
_ATTEMPTS = 3

Results = Sequence[LearningCurves | Failure]


class Cluster(Protocol):
    """Workers that learn chunks of pickled points."""

    @property
    def workers(self) -> int:
        """Number of chunks that can currently be learned at the same time."""
        ...

    def submit(self, points: list[bytes]) -> Hashable:
        """Call `learn_chunk` with these points on a worker; tasks start in the order of submission."""
        ...

    def wait(self, seconds: float) -> Iterable[tuple[Hashable, Results | None]]:
        """Wait until at least one task is done.

        Args:
            seconds: how long to wait at most.

        Returns:
            The tasks that are done and their results; None in place of the results if the worker died.

        Raises:
            ConfigError: the cluster cannot be used or reached.
        """
        ...

    def close(self) -> None:
        """Cancel all tasks, and stop the processes that were started."""
        ...


def learn_in_chunks(
    cluster: Cluster, points: Iterator[PlannedPoint | None], size: int | None, *, poll: float = 0.2
) -> Generator[PointResult, None, None]:
    """Learn points on a cluster, and close it at the end; see `Executor.learn`.

    Args:
        cluster: learns the chunks.
        points: the points to learn; None means that no point is available yet.
        size: number of points per chunk; if None, few enough that all workers stay busy to the end.
        poll: seconds to wait for a result before the points are asked again.
    """
    with closing(cluster):
        yield from _ChunkQueue(cluster, points, size, poll).run()


@dataclass
class _Chunk:
    points: list[PlannedPoint]
    pickled: list[bytes]
    deaths: int = 0


class _ChunkQueue:
    """The chunks that are in progress, and those that have to be retried."""

    def __init__(self, cluster: Cluster, points: Iterator[PlannedPoint | None], size: int | None, poll: float) -> None:
        self._cluster = cluster
        self._points = points
        self._size = size
        self._poll = poll
        self._in_progress: dict[Hashable, _Chunk] = {}
        self._retries: deque[_Chunk] = deque()
        self._taken = 0
        self._ended = False

    def run(self) -> Generator[PointResult, None, None]:
        yield from self._fill()
        while self._in_progress or not self._ended:
            results: list[PointResult] = []
            if self._in_progress:
                for task, curves in self._cluster.wait(self._poll):
                    results += self._done(self._in_progress.pop(task), curves)
            else:
                sleep(self._poll)
            # Submit the next chunks before yielding: the consumer spends time on the results.
            results += self._fill()
            yield from results

    def _fill(self) -> list[PointResult]:
        """Submit chunks until all workers are busy; return the points that cannot be pickled."""
        failed: list[PointResult] = []
        most = _IN_FLIGHT * max(self._cluster.workers, 1)
        while len(self._in_progress) < most:
            chunk = self._retries.popleft() if self._retries else self._take(most, failed)
            if not chunk.points:
                break
            self._in_progress[self._cluster.submit(chunk.pickled)] = chunk
        return failed

    def _take(self, in_flight: int, failed: list[PointResult]) -> _Chunk:
        """Return the next points. The first chunks are small, so that all workers get a share of few points."""
        most, steps = self._size or min(_MAX_POINTS, 1 + self._taken // in_flight), 0.0
        chunk = _Chunk([], [])
        while len(chunk.points) < most and (self._size or steps < _MAX_STEPS):
            planned = self._next()
            if planned is None:
                break
            self._taken += 1
            try:
                chunk.pickled.append(pickled(planned))
            except Exception as error:
                failed.append((planned, error))
                continue
            chunk.points.append(planned)
            steps += expected_work(planned.point, planned.periods_begun)
        return chunk

    def _next(self) -> PlannedPoint | None:
        if self._ended:
            return None
        try:
            return next(self._points)
        except StopIteration:
            self._ended = True
            return None

    def _done(self, chunk: _Chunk, results: Results | None) -> Iterator[PointResult]:
        if results is not None:
            for planned, result in zip(chunk.points, results, strict=True):
                yield planned, result.error() if isinstance(result, Failure) else result
        elif len(chunk.points) > 1:
            # Retry each point alone: one of them may have killed the worker.
            self._retries += [
                _Chunk([one], [pickled]) for one, pickled in zip(chunk.points, chunk.pickled, strict=True)
            ]
        elif chunk.deaths + 1 < _ATTEMPTS:
            self._retries.append(_Chunk(chunk.points, chunk.pickled, chunk.deaths + 1))
        else:
            reason = f"{_ATTEMPTS} workers died while they learned this point; it may need more memory than they have"
            yield chunk.points[0], RuntimeError(reason)
