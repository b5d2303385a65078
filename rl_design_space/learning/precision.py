"""Enough periods: batches of them are learned until a mean is known precisely.

The interval is an asymptotic confidence sequence (Waudby-Smith, Arbour, Sinha, Kennedy and Ramdas, Ann. Statist. 52,
2024): it holds the true mean at all numbers of periods together in 95 % of cases, so learning may stop when it is
narrow, and go on later. docs/decisions/0028-enough-periods.md says why, and how often it holds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, Task
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measure_kinds import PeriodMeasure
from rl_design_space.learning.measure_spec import parsed
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves

_ALPHA = 0.05
#: Numbers of periods at which a mean is looked at: each is so many times the one before it.
_GROWTH = 1.25
#: The interval is narrowest, relative to the number of periods, at so many times the first batch.
_NARROWEST = 4
#: The next look is at such a share of the periods that seem to be needed, at so many times the present ones at most: a
#: single long period makes many seem to be needed.
_CAUTION, _LARGEST_STEP = 0.9, 4


@dataclass(frozen=True)
class Precision:
    """A rule that says when a point has enough periods.

    Attributes:
        relative: half the width of the interval, as a share of the mean.
        of: the measure whose mean is meant.
        first: periods of the first batch.
        at_most: maximum number of periods.
    """

    relative: float
    of: str
    first: int
    at_most: int

    @classmethod
    def of_task(cls, task: Task) -> Precision | None:
        """Return the rule of a task; None if it has a fixed number of periods."""
        if task.precision is None:
            return None
        return cls(task.precision, task.precision_of, task.periods, task.periods_at_most)

    def check(self) -> None:
        """Check the measure.

        Raises:
            ConfigError: there is no such measure, or it is not the mean of a number of each period.
        """
        if parsed(self.of).is_own:
            reason = "should be a measure of this package: the code of your own is not part of a point"
            raise ConfigError.at("task.precision_of", self.of, reason)
        try:
            measured = measure(self.of)
        except ConfigError as error:
            raise ConfigError(f"task.precision_of={self.of}: {error}") from error
        if not (isinstance(measured, PeriodMeasure) and measured.statistic.is_mean):
            reason = "should be the mean of a number of each period, such as total_steps or steps_after=30"
            raise ConfigError.at("task.precision_of", self.of, reason)

    def looks(self) -> Iterator[int]:
        """Yield the numbers of periods at which the mean is looked at."""
        number, last = 0, 0
        while last < self.at_most:
            look = min(self.at_most, math.ceil(self.first * _GROWTH**number))
            if look > last:
                yield look
            number, last = number + 1, look

    def reached(self, learned: LearningCurves) -> float:
        """Return half the width of the interval, as a share of the mean; infinity if the mean is 0 or not known."""
        each = measure(self.of).each(learned)
        assert each is not None
        mean = float(each.mean())
        width = anytime_half_width(each, self.first)
        return width / abs(mean) if mean and math.isfinite(mean) else math.inf

    def next_look(self, learned: LearningCurves) -> int | None:
        """Return how many periods should be learned in all; None if these are enough.

        Looks long before the precision can be reached are left out. Which are taken follows from the result alone.
        """
        return self.following(len(learned.steps), self.reached(learned))

    def following(self, periods: int, reached: float) -> int | None:
        """Return how many periods should be learned in all, of so many with which a precision is reached."""
        if reached <= self.relative or periods >= self.at_most:
            return None
        needed = periods * min(_CAUTION * (reached / self.relative) ** 2, _LARGEST_STEP)
        later = [look for look in self.looks() if look > periods]
        return max([look for look in later if look <= needed], default=later[0])


def anytime_half_width(values: FloatArray, first: int) -> float:
    """Return half the width of the 95 % confidence sequence of a mean.

    Args:
        values: numbers of the periods so far.
        first: periods of the first batch, for which the sequence is tuned.
    """
    count, spread = len(values), float(np.std(values, ddof=1))
    tuned = (-2 * math.log(_ALPHA) + math.log(-2 * math.log(_ALPHA) + 1)) / (_NARROWEST * first)
    grown = count * tuned + 1
    return spread * math.sqrt(2 * grown / (count * count * tuned) * math.log(math.sqrt(grown) / _ALPHA))


def next_stage(point: DesignPoint, learned: LearningCurves | None) -> DesignPoint | LearningCurves:
    """Return what is to be learned next of a point: the same point with a fixed number of periods; or its result.

    The result follows from the point alone, however many of its periods have been learned: of more than it needs, the
    first ones count.

    Args:
        point: the design point.
        learned: the result of its first periods; None if there is none.

    Raises:
        ValueError: `learned` is a result of another point.
    """
    if learned is not None and learned.known_point not in (None, point):
        _check_same_point(point, learned.point)
    rule = Precision.of_task(point.task)
    known = 0 if learned is None else len(learned.steps)
    if rule is None:
        return point if learned is None or known < point.task.periods else _first(learned, point)
    rule.check()
    look: int | None = rule.first
    while look is not None:
        if learned is None or known < look:
            return _fixed(point, look)
        result = learned.first(look)
        look = rule.next_look(result)
    return _first(result, _fixed(point, len(result.steps)))


def _check_same_point(point: DesignPoint, learned: DesignPoint) -> None:
    """Refuse a result of a point that differs in more than its number of periods."""
    if _fixed(point, 1) != _fixed(learned, 1):
        raise ValueError("begun: a result of another point")


def _first(learned: LearningCurves, point: DesignPoint) -> LearningCurves:
    """Return the result of a point with a fixed number of periods, which have been learned."""
    if learned.known_point is point and len(learned.steps) == point.task.periods:
        return learned
    return replace(learned.first(point.task.periods), known_point=point)


def _fixed(point: DesignPoint, periods: int) -> DesignPoint:
    return replace(point, task=point.task.with_periods(periods))
