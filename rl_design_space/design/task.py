"""The task: number of goals, and length of training (paper, sections 2 and 3)."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated

from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.identity import absent_as

_Count = Annotated[int, Field(ge=1)]
#: Measure whose mean is to be precise, and most periods, unless the user names others. Fingerprints depend on them.
_MEASURE, _AT_MOST = "total_steps", 20_000


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Task:
    """A number of goals to reach in order, in many trials.

    A trial ends at the final goal, or fails at the step cap. All trials of a period share start, goals and Q-matrix;
    every period draws a new start and goals and begins with a new Q-matrix.

    Attributes:
        goals: number of goals n, to be reached in order.
        trials: number of attempts in a period, numbered by τ.
        periods: number of repetitions of a design point, the unit of all statistics; with a precision, at least so
            many.
        max_steps: step cap: number of steps after which a trial fails.
        precision: half the width of the 95 % interval of a mean, as a share of the mean: more periods are learned until
            it is reached; None learns exactly `periods`.
        precision_of: the measure whose mean is meant.
        periods_at_most: maximum number of periods with a precision.
    """

    goals: _Count = 3
    trials: _Count = 100
    periods: _Count = 500
    max_steps: Annotated[int, Field(ge=1, lt=2**31)] = 10_000
    precision: Annotated[float, Field(gt=0, lt=1)] | None = field(default=None, metadata=absent_as(None, listed=False))
    precision_of: str = field(default=_MEASURE, metadata=absent_as(_MEASURE, listed=False))
    periods_at_most: _Count = field(default=_AT_MOST, metadata=absent_as(_AT_MOST, listed=False))

    @model_validator(mode="after")
    def _precision_has_room(self) -> Task:
        if self.precision is None:
            for name, usual in (("precision_of", _MEASURE), ("periods_at_most", _AT_MOST)):
                if (value := getattr(self, name)) != usual:
                    raise ValueError(f"task.{name}={value}: needs a precision, such as task.precision=0.02")
        elif self.periods < 2:
            raise ValueError(f"task.periods={self.periods}: a precision needs at least 2, better hundreds")
        elif self.periods_at_most < self.periods:
            raise ValueError(
                f"task.periods_at_most={self.periods_at_most}: should be at least task.periods={self.periods}, with "
                "which learning begins"
            )
        return self

    def with_periods(self, periods: int) -> Task:
        """Return the same task with exactly so many periods."""
        return Task(goals=self.goals, trials=self.trials, periods=periods, max_steps=self.max_steps)
