"""Recording results while others are being learned."""

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

#: Results that may wait to be recorded: enough that the recorder is never idle, few enough to be recorded in seconds.
_WAITING = 8


class Recorder:
    """One thread that records results in the order in which they come.

    Left without an error it has recorded everything; left with one, only what it had begun.

    Args:
        tracker: where to.
        ended: is told of each point when it is recorded, or what went wrong; in the recorder's thread.
    """

    def __init__(
        self, tracker: Tracker, ended: Callable[[PlannedPoint, LearningCurves | Exception, StoredRun | None], None]
    ) -> None:
        self._tracker = tracker
        self._ended = ended
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="record")
        self._room = BoundedSemaphore(_WAITING)
        self._waiting: deque[Future[None]] = deque()
        #: Time spent on recording.
        self.seconds = 0.0

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: BaseException | TracebackType | None) -> None:
        self._pool.shutdown(cancel_futures=kind is not None)
        if kind is None:
            self._raise_errors()

    def put(self, planned: PlannedPoint, result: LearningCurves | Exception) -> None:
        """Have a result recorded soon; wait while too many others are waiting.

        Raises:
            ConfigError: nothing can be recorded.
            Exception: whatever `ended` raised for an earlier point.
        """
        self._room.acquire()
        self._waiting.append(self._pool.submit(self._record, planned, result))
        self._raise_errors()

    def _raise_errors(self) -> None:
        while self._waiting and self._waiting[0].done():
            self._waiting.popleft().result()

    def _record(self, planned: PlannedPoint, result: LearningCurves | Exception) -> None:
        started = perf_counter()
        stored = None
        try:
            if not isinstance(result, Exception):
                stored = self._tracker.record(planned, result)
        except ConfigError:  # nothing can be recorded any more
            raise
        except Exception as error:
            result = error
        finally:
            self._tracker.unlock(planned.fingerprint)
            self._room.release()
            self.seconds += perf_counter() - started
        self._ended(planned, result, stored)
