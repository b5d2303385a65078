"""Map the design space of a reinforcement-learning problem.

import rl_design_space as rds

point = rds.DesignPoint.from_overrides(["representation=direction", "exploration=linear"])
curves = rds.simulate(point)
curves.steps  # (periods, trials) primitive moves
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.design import DesignPoint
    from rl_design_space.learning import LearningCurves, simulate

__all__ = ["ConfigError", "DesignPoint", "LearningCurves", "__version__", "simulate"]
__version__ = "0.1.0"

_HOME = {
    "DesignPoint": "rl_design_space.design",
    "LearningCurves": "rl_design_space.learning",
    "simulate": "rl_design_space.learning",
}


def __getattr__(name: str) -> Any:
    """Import the public names when they are first used, so that importing a small part stays fast."""
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
