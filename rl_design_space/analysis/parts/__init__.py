"""Parts of claims: statistics of the periods of points, each with the range that a claim gives for it."""

from rl_design_space.analysis.parts.best import BestOverBest, ExpectedOverBest
from rl_design_space.analysis.parts.combined import AllOf, AnyOf
from rl_design_space.analysis.parts.data import Data, Part, Where
from rl_design_space.analysis.parts.exploration import ExplorationOverExploration
from rl_design_space.analysis.parts.grid import AllOver, TypicalOverTypical, WithinOfAll
from rl_design_space.analysis.parts.joint import JointRatio
from rl_design_space.analysis.parts.measured import Measure
from rl_design_space.analysis.parts.observations import KnownObservations
from rl_design_space.analysis.parts.two_points import Difference, Level, Ratio

__all__ = [
    "AllOf",
    "AllOver",
    "AnyOf",
    "BestOverBest",
    "Data",
    "Difference",
    "ExpectedOverBest",
    "ExplorationOverExploration",
    "JointRatio",
    "KnownObservations",
    "Level",
    "Measure",
    "Part",
    "Ratio",
    "TypicalOverTypical",
    "Where",
    "WithinOfAll",
]
