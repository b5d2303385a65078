"""Learning that several threads can join."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from threading import Lock
from time import perf_counter, time

import numpy as np

from rl_design_space._arrays import FloatArray, Optimum
from rl_design_space.design import Task
from rl_design_space.learning.result import LearningCurves


class JointLearning(ABC):
    """The learning of a fixed number of periods, which threads can join while periods are left to begin.

    Args:
        task: of the point.
        begun: a result of the same point with fewer periods, which are not learned again.
    """

    def __init__(self, task: Task, begun: LearningCurves | None) -> None:
        self._periods, self._begun = task.periods, begun
        #: The periods that are left to begin, and how many of them a thread takes.
        self._next = self._end = task.periods
        self._size: Callable[[int, int], int] = max
        self._lock = Lock()
        self._working = 0
        self._error: BaseException | None = None
        self._started = self._ended = perf_counter()
        self._ended_at = time()

    def begin(self, first: int, size: Callable[[int, int], int]) -> None:
        """Begin, when all is prepared.

        Args:
            first: number of the first period.
            size: takes how many periods are left, and how many a thread wants at least; returns how many it takes, one
                or more.
        """
        self._next, self._size = first, size
        self._started = self._ended = perf_counter()

    @property
    def has_work(self) -> bool:
        """Whether periods are left to begin."""
        return self._next < self._end

    def work(self) -> bool:
        """Learn, together with all other threads that call this, until no period is left to begin.

        Returns:
            Whether this call has completed the learning: True once, for the last thread that ends.
        """
        with self._lock:
            if not self.has_work:
                return False
            self._working += 1
        try:
            self._work()
        except BaseException as error:
            self._error = self._error or error
            self._drop()
            if not isinstance(error, Exception):
                raise
        finally:
            with self._lock:
                self._working -= 1
                last = not self._working and not self.has_work
                self._ended, self._ended_at = perf_counter(), time()
        return last

    def stop(self) -> None:
        """Begin no more periods, so that all threads end soon."""
        self._error = self._error or RuntimeError("learning was stopped")
        self._drop()

    @property
    def is_stopped(self) -> bool:
        """Whether an error, or a call of `stop`, has made the result useless."""
        return self._error is not None

    def next_share(self, least: int = 1) -> slice | None:
        """Take periods to begin; None if none are left. Checking first would let another thread take them in between.

        Args:
            least: how many the thread wants, but no more than an even part for each thread that works.
        """
        with self._lock:
            first, left = self._next, self._end - self._next
            if left <= 0:
                return None
            self._next += min(self._size(left, min(least, -(-left // self._working))), left)
            return slice(first, self._next)

    def _drop(self) -> None:
        """Leave no periods to begin."""
        with self._lock:
            self._end = self._next

    def check(self, begun: LearningCurves, optimum: Optimum, epsilon: FloatArray) -> int:
        """Check a result of the first periods; return their number.

        Args:
            begun: the result.
            optimum: (periods,) fewest steps possible: they tell apart seeds, worlds and numbers of goals.
            epsilon: (trials,) the exploration schedule.

        Raises:
            ValueError: it is not a result of the first periods of this point.
        """
        first, trials = len(begun.steps), begun.steps.shape[1]
        if (
            first >= self._periods
            or not np.array_equal(begun.optimum, optimum[:first])
            or not np.array_equal(begun.epsilon, epsilon, equal_nan=True)
        ):
            raise ValueError(
                f"begun: a result of {first} periods of {trials} trials, which are not the first periods of this point"
            )
        return first

    def seconds(self) -> float:
        """Return the wall time of all periods; of those that were learned before at the same rate if it is unknown.

        Raises:
            Exception: the error that stopped the learning.
        """
        if self._error:
            raise self._error
        seconds = self._ended - self._started
        if self._begun is None:
            return seconds
        if not math.isnan(self._begun.seconds):
            return self._begun.seconds + seconds
        new = self._periods - len(self._begun.steps)
        return seconds * self._periods / new if new else seconds

    @property
    def ended_at(self) -> float:
        """When the learning ended, in seconds since 1970."""
        return self._ended_at

    @abstractmethod
    def curves(self) -> LearningCurves:
        """Return the result, after the learning is complete.

        Raises:
            Exception: the error that stopped the learning.
        """

    @abstractmethod
    def _work(self) -> None:
        """Learn shares until none is left."""
