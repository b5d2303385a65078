"""Learning with a learned model."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.learner import TabularLearner


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DynaQ(TabularLearner):
    """Q-learning that also learns from a model, planning steps after every step (Sutton and Barto, 8.2).

    The model holds the last reward and next observation of each observation and action. A planning step draws an
    observation met before and an action taken there, and learns from the model as from experience. The model is of
    observations: where states share one, it mixes them up. Every stage of a period begins with an empty one.

    Attributes:
        planning: number of planning steps after every step; with 0 it is Q-learning.
    """

    planning: Annotated[int, Field(ge=0, le=1000)] = 10
