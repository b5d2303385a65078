"""The executor that learns on the threads of this process."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress
from enum import Enum, auto
from queue import Full, Queue
from threading import Lock, Thread
from time import sleep
from typing import TYPE_CHECKING, Final, Literal

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.executor import PointResult

if TYPE_CHECKING:
    from rl_design_space.learning.joint import JointLearning

#: Seconds between two checks whether a point that is about to start has work for a second thread.
_HELP_INTERVAL = 0.002


class _End(Enum):
    """Sentinel after the last point."""

    END = auto()


_END: Final = _End.END


class LocalExecutor:
    """Threads of this process, one point each; when no point is left to start, they join those in progress.

    Args:
        threads: number of threads.
        poll: seconds between two checks for a stop request, or for a point when none was available.
        join_timeout: seconds that all threads together get to end when the executor is stopped.
    """

    def __init__(self, threads: int, *, poll: float = 0.2, join_timeout: float = 3.0) -> None:
        self._threads = threads
        self._poll = poll
        self._join_timeout = join_timeout
        #: Seconds that the last call of `learn` has spent on compiling, which happens once for each kind of point.
        self.compiling = 0.0

    def describe(self) -> str:
        return f"{self._threads} thread{'s' if self._threads > 1 else ''}"

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[PointResult, None, None]:
        from rl_design_space.learning.compiled import compile_timer

        with compile_timer() as seconds:
            try:
                yield from self._learn(points)
            finally:
                self.compiling = seconds()

    def _learn(self, points: Iterator[PlannedPoint | None]) -> Generator[PointResult, None, None]:
        work = _SharedWork(points, self._threads, self._poll)
        threads = [Thread(target=work.run, name=f"learn-{i}", daemon=True) for i in range(self._threads)]
        for thread in threads:
            thread.start()
        running = len(threads)
        try:
            while running:
                result = work.results.get()
                if result is None:
                    running -= 1
                elif isinstance(result, BaseException):
                    raise result
                else:
                    yield result
        finally:
            work.stop()
            for thread in threads:
                thread.join(self._join_timeout / len(threads))


class _SharedWork:
    """State shared by the threads of a local executor."""

    def __init__(self, points: Iterator[PlannedPoint | None], threads: int, poll: float) -> None:
        #: Results, errors that end the sweep, and one None per thread when it ends. Bounded: threads block while the
        #: consumer lags.
        self.results: Queue[PointResult | BaseException | None] = Queue(2 * threads)
        self._points = points
        self._threads = threads
        self._poll = poll
        self._in_progress: dict[JointLearning, PlannedPoint] = {}
        #: Number of points that were taken but are not in `_in_progress` yet; they may soon have work for a helper.
        self._starting = 0
        self._taking, self._changing = Lock(), Lock()
        self._stopping = False

    def run(self) -> None:
        """Learn one point after the other; help with points in progress when no other is available."""
        try:
            while (planned := self._next()) is not _END:
                if planned is not None:
                    self._learn(planned)
                elif not self._help():
                    sleep(self._poll)
            while not self._stopping and (self._help() or self._starting):
                sleep(_HELP_INTERVAL)
        except BaseException as error:
            self._put(error)
        else:
            self._put(None)

    def stop(self) -> None:
        """Make all threads end soon, without further results."""
        self._stopping = True
        with self._changing:
            for learning in self._in_progress:
                learning.stop()

    def _next(self) -> PlannedPoint | Literal[_End.END] | None:
        with self._taking:
            planned = _END if self._stopping else next(self._points, _END)
            if isinstance(planned, PlannedPoint):
                with self._changing:
                    self._starting += 1
            return planned

    def _learn(self, planned: PlannedPoint) -> None:
        try:
            learning = self._begun(planned, planned.begun)
        finally:
            with self._changing:
                self._starting -= 1
        if learning:
            self._join(learning, planned)

    def _begun(self, planned: PlannedPoint, learned: LearningCurves | None) -> JointLearning | None:
        """Begin to learn what a point still needs, and return it; put its result and return None if it is complete."""
        from rl_design_space.learning.precision import next_stage
        from rl_design_space.learning.simulation import learning_of

        try:
            stage = next_stage(planned.point, learned)
            if isinstance(stage, LearningCurves):
                self._put((planned, stage))
                return None
            learning = learning_of(stage, self._threads, learned)
        except Exception as error:
            self._put((planned, error))
            return None
        with self._changing:
            self._in_progress[learning] = planned
        return learning

    def _help(self) -> bool:
        """Work on a point of another thread; return False if no point has work for a second thread."""
        with self._changing:
            found = next((item for item in self._in_progress.items() if item[0].has_work), None)
        if found:
            self._join(*found)
        return found is not None

    def _join(self, begun: JointLearning, planned: PlannedPoint) -> None:
        """Work on a point; the thread that finishes it puts its result."""
        learning: JointLearning | None = begun
        while learning and learning.work():
            with self._changing:
                del self._in_progress[learning]
            try:
                result = learning.curves()
            except Exception as error:
                self._put((planned, error))
                return
            learning = self._begun(planned, result)

    def _put(self, result: PointResult | BaseException | None) -> None:
        while not self._stopping:
            with suppress(Full):
                self.results.put(result, timeout=self._poll)
                return
