"""The task: number of goals, and length of training (paper, sections 2 and 3)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT

_Count = Annotated[int, Field(ge=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Task:
    """A number of goals to reach in order, in many trials.

    A trial ends at the final goal, or fails at the step cap. All trials of a period share start, goals and Q-matrix;
    every period draws a new start and goals and begins with a new Q-matrix.

    Attributes:
        goals: number of goals n, to be reached in order.
        trials: number of attempts in a period, numbered by τ.
        periods: number of repetitions of a design point, the unit of all statistics.
        max_steps: step cap: number of steps after which a trial fails.
    """

    goals: _Count = 3
    trials: _Count = 100
    periods: _Count = 500
    max_steps: Annotated[int, Field(ge=1, lt=2**31)] = 10_000
