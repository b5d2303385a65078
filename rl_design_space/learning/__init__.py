"""Learning: tables in, learning curves out."""

from rl_design_space.learning.curves import LearningCurves
from rl_design_space.learning.simulate import simulate

__all__ = ["LearningCurves", "simulate"]
