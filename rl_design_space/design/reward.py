"""Reward functions (paper, sections 2 and 3.4)."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT


@runtime_checkable
class Reward(Protocol):
    """Rewards of the three kinds of moves."""

    def table(self) -> FloatArray:
        """(3,) float64: reward of a move, of a move onto a due sub-goal, of a move onto the due final goal."""
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class GoalReward:
    """One number for an ordinary move, one for a due sub-goal, one for the due final goal.

    The paper's three functions are *many rewards* (-0.1, 1, 10), *each success* (0, 1, 10) and *end reward*
    (0, 0, 10). What a goal that is not due yields is a reading of the learner, `learner.out_of_order`.

    Attributes:
        step: reward of an ordinary move.
        sub_goal: reward of a move onto the due sub-goal.
        final_goal: reward of a move onto the due final goal.
    """

    step: float = -0.1
    sub_goal: float = 1.0
    final_goal: float = 10.0

    def table(self) -> FloatArray:
        return np.array((self.step, self.sub_goal, self.final_goal), dtype=np.float64)
