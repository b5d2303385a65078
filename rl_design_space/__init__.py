"""Map the design space of a reinforcement-learning problem.

import rl_design_space as rds

point = rds.DesignPoint(representation=rds.Direction(), exploration=rds.Linear(k=0.02), world=rds.Torus(size=20))
curves = rds.simulate(point)
curves.steps  # (periods, trials) primitive moves
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rl_design_space._version import __version__
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

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

#: Where the public names are from; the others are in `design`.
_HOME = {
    "LearningCurves": "learning",
    "simulate": "learning",
    **dict.fromkeys(("load_runs", "load_curves", "load_periods"), "tracking.load"),
}


if not TYPE_CHECKING:  # a type checker would take any name, also a mistyped one, for a public name

    def __getattr__(name: str) -> Any:
        """Import the public names when they are first used, so that importing a small part stays fast."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        found = getattr(import_module(f"rl_design_space.{_HOME.get(name, 'design')}"), name)
        if name == "DesignPoint":
            found.from_overrides = classmethod(_from_overrides)
        return found


def _from_overrides(cls: type, overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> DesignPoint:
    """Return the point that these command-line overrides describe, see `plan.planner.point_from_overrides`."""
    from rl_design_space.plan.planner import point_from_overrides

    return point_from_overrides(overrides, config_dir)


def __dir__() -> list[str]:
    """All public names, imported or not: they are what tab completion offers."""
    return sorted({*globals(), *__all__})
