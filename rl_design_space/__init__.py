"""Map the design space of a reinforcement-learning problem.

import rl_design_space as rds

point = rds.DesignPoint(representation=rds.Direction(), exploration=rds.Linear(k=0.02), world=rds.Torus(size=20))
curves = rds.simulate(point)
curves.steps  # (periods, trials) steps
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rl_design_space._version import __version__ as __version__
from rl_design_space.errors import ConfigError as ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rl_design_space.commands.python_record import record as record
    from rl_design_space.commands.python_sweep import sweep as sweep
    from rl_design_space.design import *  # noqa: F403 (every option is public)
    from rl_design_space.design import DesignPoint
    from rl_design_space.learning import LearningCurves as LearningCurves
    from rl_design_space.learning import simulate as simulate
    from rl_design_space.report.inside.watched import watch as watch
    from rl_design_space.tracking.load import load_curves as load_curves
    from rl_design_space.tracking.load import load_periods as load_periods
    from rl_design_space.tracking.load import load_runs as load_runs

#: Modules of the public names; those of `design` are public as well.
_HOME = {
    "LearningCurves": "learning",
    "simulate": "learning",
    "record": "commands.python_record",
    "sweep": "commands.python_sweep",
    "watch": "report.inside.watched",
    **dict.fromkeys(("load_runs", "load_curves", "load_periods"), "tracking.load"),
}

if not TYPE_CHECKING:  # otherwise every misspelt name would pass as Any

    def __getattr__(name: str) -> Any:
        """Import the public names when they are first used, so that importing a small part stays fast."""
        if name == "__all__":
            return _public_names()
        if name in _HOME:
            return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
        if not name.startswith("_") and name in (design := import_module(f"{__name__}.design")).__all__:
            found = getattr(design, name)
            if name == "DesignPoint":
                found.from_overrides = classmethod(_from_overrides)
            return found
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _public_names() -> list[str]:
    """Return the names that a star import takes: what makes a design point, what learns, and what loads."""
    from dataclasses import is_dataclass  # a third of the time that importing this package takes

    design = import_module(f"{__name__}.design")
    choices = [name for name in design.__all__ if is_dataclass(getattr(design, name))]
    return sorted([*choices, *_HOME, "ConfigError", "__version__"])


def __dir__() -> list[str]:
    """Return all public names, imported or not: they are what tab completion offers."""
    return sorted({*globals(), *_public_names()})


def _from_overrides(cls: type, overrides: Sequence[str] = (), config_dir: str | Path | None = None) -> DesignPoint:
    """Return the point that these command-line overrides describe, see `plan.planner.point_from_overrides`."""
    from rl_design_space.plan.planner import point_from_overrides

    return point_from_overrides(overrides, config_dir)
