"""Executors: who learns the points of a sweep."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress
from enum import Enum, auto
from queue import Full, Queue
from threading import Lock, Thread
from time import sleep
from typing import TYPE_CHECKING, Final, Literal, Protocol, runtime_checkable

from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import PlannedPoint

if TYPE_CHECKING:
    from rl_design_space.learning.simulation import Learning

#: Seconds that threads are given to notice that they are to stop; between two looks whether they are to, or whether
#: there is a point again; and whether one that is about to begin has work for two.
_PATIENCE, _MOMENT, _GLANCE = 3, 0.2, 0.002


class _End(Enum):
    """What comes after the last point."""

    END = auto()


_END: Final = _End.END

Learned = tuple[PlannedPoint, LearningCurves | Exception]


class Executor(Protocol):
    """Learns many points at a time.

    Points are taken from an iterator one after the other, each only when it can soon begin: whoever gives them claims
    them at that moment. It may yield None, when there is nothing at the moment, but will be later. It is never asked by
    two threads at once, but not always by the same. Results come in the order in which they are ready.
    """

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[Learned, None, None]:
        """The learning curves of these points, or what went wrong; closing the iterator stops everything."""
        ...

    def describe(self) -> str:
        """Who learns, for people: `2 threads`."""
        ...


@runtime_checkable
class PointLauncher(Protocol):
    """A launcher of Hydra's that learns design points instead of running jobs.

    Attributes:
        dumps: whether each point leaves its resolved config and overrides in a folder of its own.
    """

    dumps: bool

    def executor(self, threads: int) -> Executor:
        """Return what learns the points, with so many cores of this machine."""
        ...


class LocalExecutor:
    """Threads of this process, a point each; when no point is left to begin, they join those that are under way."""

    def __init__(self, threads: int) -> None:
        self._threads = threads

    def describe(self) -> str:
        return f"{self._threads} thread{'s' if self._threads > 1 else ''}"

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[Learned, None, None]:
        work = _Work(points, self._threads)
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
                thread.join(_PATIENCE / len(threads))


class _Work:
    """What the threads of a local executor share."""

    def __init__(self, points: Iterator[PlannedPoint | None], threads: int) -> None:
        #: Results, errors that end everything, and None from each thread that has nothing more to do. Few results fit:
        #: whoever learns faster than results are taken has to wait.
        self.results: Queue[Learned | BaseException | None] = Queue(2 * threads)
        self._points = points
        self._threads = threads
        self._under_way: dict[Learning, PlannedPoint] = {}
        #: Points that a thread has taken and is not yet learning; they may need help in a moment.
        self._beginning = 0
        self._taking, self._changing = Lock(), Lock()
        self._stopping = False

    def run(self) -> None:
        """Learn point after point; help with those that others have begun when there is no other."""
        try:
            while (planned := self._next()) is not _END:
                if planned is not None:
                    self._learn(planned)
                elif not self._help():
                    sleep(_MOMENT)
            while not self._stopping and (self._help() or self._beginning):
                sleep(_GLANCE)
        except BaseException as error:
            self._tell(error)
        else:
            self._tell(None)

    def stop(self) -> None:
        """Let all threads end soon, without another result."""
        self._stopping = True
        with self._changing:
            for learning in self._under_way:
                learning.stop()

    def _next(self) -> PlannedPoint | Literal[_End.END] | None:
        with self._taking:
            planned = _END if self._stopping else next(self._points, _END)
            if isinstance(planned, PlannedPoint):
                with self._changing:
                    self._beginning += 1
            return planned

    def _learn(self, planned: PlannedPoint) -> None:
        from rl_design_space.learning.simulation import Learning

        try:
            learning = Learning(planned.point, self._threads)
        except Exception as error:
            self._tell((planned, error))
            return
        else:
            with self._changing:
                self._under_way[learning] = planned
        finally:
            with self._changing:
                self._beginning -= 1
        self._join(learning, planned)

    def _help(self) -> bool:
        """Work on a point of another thread, if any has work for two."""
        with self._changing:
            found = next((item for item in self._under_way.items() if item[0].has_work), None)
        if found:
            self._join(*found)
        return found is not None

    def _join(self, learning: Learning, planned: PlannedPoint) -> None:
        """Work on a point; the last of those who do tells of it."""
        if not learning.work():
            return
        with self._changing:
            del self._under_way[learning]
        try:
            result: LearningCurves | Exception = learning.curves()
        except Exception as error:
            result = error
        self._tell((planned, result))

    def _tell(self, result: Learned | BaseException | None) -> None:
        while not self._stopping:
            with suppress(Full):
                self.results.put(result, timeout=_MOMENT)
                return
