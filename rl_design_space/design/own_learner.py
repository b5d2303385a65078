"""Learners of the user's own: a few lines that are compiled."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.learner import TabularLearner


class Step(NamedTuple):
    """What an update function gets to know of a step.

    Attributes:
        row: row of the Q-matrix of the observation.
        action: the action taken there.
        reward: the reward.
        next_row: row of the next observation.
        next_action: the action that is taken there, if the learner `chooses_first`; otherwise 0.
        terminal: whether the step has reached the final goal: there is no next value.
        alpha: α now.
        gamma: γ.
    """

    row: int
    action: int
    reward: float
    next_row: int
    next_action: int
    terminal: bool
    alpha: float
    gamma: float


@dataclass(frozen=True, kw_only=True, config=STRICT)
class OwnLearner(TabularLearner):
    """Base of learners of your own: derive from it, and give `update`.

    By itself it is one-step Q-learning.
    """

    #: Whether the next action is chosen before the update.
    chooses_first: ClassVar[bool] = False

    @property
    def parameters(self) -> tuple[float, ...]:
        """Numbers of your own that the update uses."""
        return ()

    @staticmethod
    def update(step: Step, q: Any, memory: Any, parameters: Any) -> float:
        """Learn from a step, and return the error of the old value. It is compiled by Numba.

        Args:
            step: the step.
            q: (rows, actions) float64, the Q-matrix; changed in place.
            memory: (rows, actions) float64, for what you like: all zeros when a period begins.
            parameters: those above.
        """
        value = 0.0 if step.terminal else q[step.next_row].max()
        error: float = step.reward + step.gamma * value - q[step.row, step.action]
        q[step.row, step.action] += step.alpha * error
        return error
