"""The design choices. Each option is a frozen, validated value that yields plain data for the learner."""

from rl_design_space.design.exploration import Constant, Exploration, Exponential, Linear, Sigmoidal
from rl_design_space.design.learner import QLearning
from rl_design_space.design.msa import MultiStepActions
from rl_design_space.design.point import DesignPoint
from rl_design_space.design.representation import (
    AdHoc,
    Direct,
    Direction,
    Distance,
    Representation,
    SizedRepresentation,
    encode,
)
from rl_design_space.design.reward import GoalReward, Reward
from rl_design_space.design.task import Task
from rl_design_space.design.world import MOVES, ObstructedWorld, Torus, Walled, World, cell_count, open_cells

__all__ = [
    "MOVES",
    "AdHoc",
    "Constant",
    "DesignPoint",
    "Direct",
    "Direction",
    "Distance",
    "Exploration",
    "Exponential",
    "GoalReward",
    "Linear",
    "MultiStepActions",
    "ObstructedWorld",
    "QLearning",
    "Representation",
    "Reward",
    "Sigmoidal",
    "SizedRepresentation",
    "Task",
    "Torus",
    "Walled",
    "World",
    "cell_count",
    "encode",
    "open_cells",
]
