"""The task: how many goals, and how long the agent may practise (paper, sections 2 and 3)."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT

_Count = Annotated[int, Field(ge=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Task:
    """Reach `goals` goals in their order, in `trials` trials a period; `periods` periods make a design point.

    A trial ends at the final goal or after `max_steps` primitive moves. All trials of a period share start, goals
    and Q-matrix; every period draws and learns anew.
    """

    goals: _Count = 3
    trials: _Count = 100
    periods: _Count = 500
    max_steps: Annotated[int, Field(ge=1, lt=2**31)] = 10_000
