"""Learners: what they share, and tabular Q-learning, the paper's (section 2)."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.design.identity import absent_as

#: How the step size falls unless the user says it. Fingerprints depend on these values.
_FALL, _POWER = 0.01, 0.7


@dataclass(frozen=True, kw_only=True, config=STRICT)
class TabularLearner:
    """What all learners share: a Q-matrix, a discount, step sizes, and the readings of what the paper leaves open.

    Attributes:
        alpha: learning rate α; with 0 nothing is learned.
        alpha_schedule: α over time: `constant`; `visits`, α/N, where N counts the updates of the observation and action
            in this period; `polynomial`, α/N^ω; `linear`, max(α - c·τ, 0) in trial τ = 0, 1, ….
        alpha_fall: c, by which α falls from trial to trial (`linear` only).
        alpha_power: ω (`polynomial` only); Q-learning converges for ½ < ω ≤ 1 (Even-Dar and Mansour 2003).
        gamma: discount factor γ.
        initial_q: initial Q-value of every observation and action in a period.
        explore: actions that exploration draws from: all but the greedy one (`non_greedy`, which fits Table 4), or
            `all`, as the text says.
        ties: greedy action among equal maxima: drawn at `random`, or the `first`.
        out_of_order: reward of a step onto a goal that is not due: the ordinary `step_reward`, or `zero`.
    """

    alpha: Annotated[float, Field(ge=0, le=1)] = 0.1
    gamma: Annotated[float, Field(ge=0, le=1)] = 0.9
    initial_q: float = 0.0
    explore: Literal["non_greedy", "all"] = "non_greedy"
    ties: Literal["random", "first"] = "random"
    out_of_order: Literal["step_reward", "zero"] = "step_reward"
    alpha_schedule: Literal["constant", "visits", "linear", "polynomial"] = field(
        default="constant", metadata=absent_as("constant", listed=False)
    )
    alpha_fall: Annotated[float, Field(ge=0)] = field(default=_FALL, metadata=absent_as(_FALL, listed=False))
    alpha_power: Annotated[float, Field(gt=0, le=1)] = field(default=_POWER, metadata=absent_as(_POWER, listed=False))

    @model_validator(mode="after")
    def _values_belong_to_the_schedule(self) -> TabularLearner:
        for name, usual, schedule in (("alpha_fall", _FALL, "linear"), ("alpha_power", _POWER, "polynomial")):
            value = getattr(self, name)
            if value != usual and self.alpha_schedule != schedule:
                raise ValueError(
                    f"learner.{name}={value}: belongs to learner.alpha_schedule={schedule}, not {self.alpha_schedule}"
                )
        return self

    def alphas(self, trials: int) -> FloatArray:
        """Return α by trial, (trials,) float64; with `visits` and `polynomial`, that of the first update."""
        fall = self.alpha_fall if self.alpha_schedule == "linear" else 0.0
        return np.maximum(self.alpha - fall * np.arange(trials, dtype=np.float64), 0.0)

    @property
    def visit_power(self) -> float:
        """The power of the number of updates by which α is divided; 0 if it does not depend on them."""
        return {"visits": 1.0, "polynomial": self.alpha_power}.get(self.alpha_schedule, 0.0)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QLearning(TabularLearner):
    """Q(s,a) ← Q(s,a) + α·(r + γ·max Q(s',·) - Q(s,a)), with the readings of what the paper leaves open.

    Attributes:
        update: update rule: `standard`, or as `printed` in the paper, where the discount also covers the old value:
            Q(s,a) ← Q(s,a) + α·(r + γ·(max Q(s',·) - Q(s,a))).
    """

    update: Literal["standard", "printed"] = "standard"
