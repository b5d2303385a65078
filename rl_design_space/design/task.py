"""The task: how many goals, and how long the agent may practise (paper, sections 2 and 3)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT

_Count = Annotated[int, Field(ge=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Task:
    """Reach a number of goals in their order, again and again.

    A trial ends at the final goal, or fails. All trials of a period share start, goals and Q-matrix; every period
    draws and learns anew.

    Attributes:
        goals: n, to be reached in their order.
        trials: τ, attempts of a period.
        periods: repetitions that make a design point, the unit of all statistics.
        max_steps: primitive moves after which a trial has failed.
    """

    goals: _Count = 3
    trials: _Count = 100
    periods: _Count = 500
    max_steps: Annotated[int, Field(ge=1, lt=2**31)] = 10_000
