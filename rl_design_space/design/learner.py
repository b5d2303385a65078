"""The learner: tabular Q-learning with ε-greedy behaviour (paper, section 2)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QLearning:
    """Q(s,a) ← Q(s,a) + α·(r + γ·max Q(s',·) - Q(s,a)), with the readings of what the paper leaves open.

    Attributes:
        alpha: learning rate α; with 0 nothing is learned.
        gamma: discount factor γ.
        initial_q: initial Q-value of every observation and action in a period.
        explore: actions that exploration draws from: all but the greedy one (`non_greedy`, which fits Table 4), or
            `all`, as the text says.
        ties: greedy action among equal maxima: drawn at `random`, or the `first`.
        out_of_order: reward of a step onto a goal that is not due: the ordinary `step_reward`, or `zero`.
        update: update rule: `standard`, or as `printed` in the paper, where the discount also covers the old value:
            Q(s,a) ← Q(s,a) + α·(r + γ·(max Q(s',·) - Q(s,a))).
    """

    alpha: Annotated[float, Field(ge=0, le=1)] = 0.1
    gamma: Annotated[float, Field(ge=0, le=1)] = 0.9
    initial_q: float = 0.0
    explore: Literal["non_greedy", "all"] = "non_greedy"
    ties: Literal["random", "first"] = "random"
    out_of_order: Literal["step_reward", "zero"] = "step_reward"
    update: Literal["standard", "printed"] = "standard"
