"""Double Q-learning."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.learner import TabularLearner


@dataclass(frozen=True, kw_only=True, config=STRICT)
class DoubleQ(TabularLearner):
    """Two Q-matrices, each a judge of the other's best action (Sutton and Barto, 6.7; van Hasselt 2010).

    A coin decides which one learns: Q₁(s,a) ← Q₁(s,a) + α·(r + γ·Q₂(s', argmax Q₁(s',·)) - Q₁(s,a)), or the same with
    their parts exchanged. Behaviour follows their mean, which is also what is shown of the learner, and what a stage
    carries to the next.
    """
