"""Reward functions (paper, sections 2 and 3.4)."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT


@runtime_checkable
class Reward(Protocol):
    """Rewards of the three kinds of steps."""

    def table(self) -> FloatArray:
        """Return the rewards of a step, of reaching the due sub-goal, and of reaching the final goal, (3,) float64."""
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GoalReward:
    """One reward for an ordinary step, one for the due sub-goal, one for the due final goal.

    The paper's three functions are *many rewards* (-0.1, 1, 10), *each success* (0, 1, 10) and *end reward*
    (0, 0, 10). The reward of a goal that is not due is `learner.out_of_order`.

    Attributes:
        step: reward of an ordinary step.
        sub_goal: reward of a step onto the due sub-goal.
        final_goal: reward of a step onto the due final goal.
    """

    step: float = -0.1
    sub_goal: float = 1.0
    final_goal: float = 10.0

    def table(self) -> FloatArray:
        return np.array((self.step, self.sub_goal, self.final_goal), dtype=np.float64)
