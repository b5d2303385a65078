"""Map the design space of a reinforcement-learning problem.

import rl_design_space as rds

point = rds.DesignPoint(representation=rds.Direction(), exploration=rds.Linear(k=0.02), world=rds.Torus(size=20))
curves = rds.simulate(point)
curves.steps  # (periods, trials) primitive moves
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.design import (
        AdHoc,
        Constant,
        DesignPoint,
        Direct,
        Direction,
        Distance,
        Exponential,
        GoalReward,
        Linear,
        MultiStepActions,
        QLearning,
        Sigmoidal,
        Task,
        Torus,
        Walled,
    )
    from rl_design_space.learning import LearningCurves, simulate
    from rl_design_space.tracking.load import load_curves, load_periods, load_runs

__all__ = [
    "AdHoc",
    "ConfigError",
    "Constant",
    "DesignPoint",
    "Direct",
    "Direction",
    "Distance",
    "Exponential",
    "GoalReward",
    "LearningCurves",
    "Linear",
    "MultiStepActions",
    "QLearning",
    "Sigmoidal",
    "Task",
    "Torus",
    "Walled",
    "__version__",
    "load_curves",
    "load_periods",
    "load_runs",
    "simulate",
]
__version__ = "0.1.0"

#: Where the public names are from; the others are in `design`.
_HOME = {
    "LearningCurves": "learning",
    "simulate": "learning",
    **dict.fromkeys(("load_runs", "load_curves", "load_periods"), "tracking.load"),
}


def __getattr__(name: str) -> Any:
    """Import the public names when they are first used, so that importing a small part stays fast."""
    if name in __all__:
        return getattr(import_module(f"rl_design_space.{_HOME.get(name, 'design')}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """All public names, imported or not: they are what tab completion offers."""
    return sorted({*globals(), *__all__})
