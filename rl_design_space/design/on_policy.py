"""Learners of the values of their own behaviour."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.design.learner import TabularLearner


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sarsa(TabularLearner):
    """Q(s,a) ← Q(s,a) + α·(r + γ·Q(s',a') - Q(s,a)), where a' is the action taken next (Sutton and Barto, 6.4).

    The next action is chosen before the update. At the step cap it is chosen, too, though not taken: the last state is
    not terminal.
    """


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ExpectedSarsa(TabularLearner):
    """Q(s,a) ← Q(s,a) + α·(r + γ·Σ π(b|s')·Q(s',b) - Q(s,a)), π the behaviour itself (Sutton and Barto, 6.6).

    π is what the next choice would be drawn from before the update: exploration, ties and all.
    """
