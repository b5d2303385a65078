"""Record results while other points are being learned."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import BoundedSemaphore
from time import perf_counter
from types import TracebackType

from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking.tracker import StoredRun, Tracker

#: Maximum number of queued results: enough that the recorder is never idle, few enough to be recorded in seconds.
_MAX_QUEUED = 8


class Recorder:
    """A thread that records results in the order in which they are put.

    A context manager: on a normal exit all results are recorded; on an exception, only those whose recording has begun.

    Args:
        tracker: records the results.
        on_recorded: called in the recorder's thread with each point, its learning curves or its error, and its run,
            which is None if the point failed.
    """

    def __init__(
        self,
        tracker: Tracker,
        on_recorded: Callable[[PlannedPoint, LearningCurves | Exception, StoredRun | None], None],
    ) -> None:
        self._tracker = tracker
        self._on_recorded = on_recorded
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="record")
        self._room = BoundedSemaphore(_MAX_QUEUED)
        self._queued: deque[Future[None]] = deque()
        #: Seconds spent on recording.
        self.seconds = 0.0

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: BaseException | TracebackType | None) -> None:
        self._pool.shutdown(cancel_futures=kind is not None)
        if kind is None:
            self._raise_errors()

    def put(self, planned: PlannedPoint, result: LearningCurves | Exception) -> None:
        """Queue a result; block while the queue is full.

        Raises:
            ConfigError: nothing can be recorded.
            Exception: the error that `on_recorded` raised for an earlier point.
        """
        self._room.acquire()
        self._queued.append(self._pool.submit(self._record, planned, result))
        self._raise_errors()

    def _raise_errors(self) -> None:
        while self._queued and self._queued[0].done():
            self._queued.popleft().result()

    def _record(self, planned: PlannedPoint, result: LearningCurves | Exception) -> None:
        started = perf_counter()
        stored = None
        try:
            if not isinstance(result, Exception):
                stored = self._tracker.record(planned, result)
        except ConfigError:  # no further result can be recorded either
            raise
        except Exception as error:
            result = error
        finally:
            self._tracker.unlock(planned.fingerprint)
            self._room.release()
            self.seconds += perf_counter() - started
        self._on_recorded(planned, result, stored)
