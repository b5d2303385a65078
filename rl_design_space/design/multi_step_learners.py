"""Learners whose targets reach over several actions."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.learner import TabularLearner


@dataclass(frozen=True, kw_only=True, config=STRICT)
class NStep(TabularLearner):
    """Targets of n steps: Sarsa (Sutton and Barto, 7.2) or tree backup (7.5).

    A trial that ends sooner is learned from to its end. At the step cap the last state is not terminal: targets are
    shorter there and end with its value.

    Attributes:
        n: number of steps of a target.
        backup: `sarsa`: rewards received and the value of the last action; `tree`: at each step the behaviour's
            expectation over the actions not taken, so that with n = 1 it is expected Sarsa.
    """

    n: Annotated[int, Field(ge=1, le=1000)] = 4
    backup: Literal["sarsa", "tree"] = "sarsa"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QLambda(TabularLearner):
    """Watkins's Q(λ): Q-learning with eligibility traces (Sutton and Barto, 12.10; first edition, 7.6).

    The error of a step updates all actions with a trace. Traces fall by γ·λ a step, end at an exploratory action (one
    that is not greedy when it is chosen, after the update), and begin anew with a trial. A trace below 10⁻⁸ is dropped.

    Attributes:
        trace_decay: λ; with 0 it is Q-learning.
        traces: the trace of the action taken: set to 1 (`replacing`), or raised by 1 (`accumulating`).
    """

    trace_decay: Annotated[float, Field(ge=0, le=1)] = 0.8
    traces: Literal["replacing", "accumulating"] = "replacing"
