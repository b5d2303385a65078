"""Which points the kernel learns in lanes."""

from __future__ import annotations

from typing import Any

from rl_design_space.design.adaptive import ClosedLoop, level_of
from rl_design_space.design.learner import QLearning


def learned_in_lanes(point: Any) -> bool:
    """Return whether a point needs nothing but Q-learning with constant α and a schedule of ε."""
    learner, exploration = point.learner, point.exploration
    scheduled = level_of(exploration) == "epsilon" and not isinstance(exploration, ClosedLoop)
    return scheduled and isinstance(learner, QLearning) and learner.alpha_schedule == "constant"
