"""The objective: the scalar that a run returns to a sweeper that optimizes."""

from __future__ import annotations

from collections.abc import Mapping

from rl_design_space.errors import ConfigError


def objective_value(name: str, scalars: Mapping[str, float]) -> float:
    """Return the value of the objective among the scalars of a point.

    Raises:
        ConfigError: the point has no such scalar.
    """
    if name not in scalars:
        raise ConfigError.at("objective", name, f"this point has no such scalar, only {', '.join(scalars)}")
    return scalars[name]
