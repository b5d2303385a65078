"""The objective: the scalar of a point that a run returns to a sweeper that searches."""

from __future__ import annotations

from collections.abc import Mapping

from rl_design_space.errors import ConfigError


def objective_value(name: str, scalars: Mapping[str, float]) -> float:
    """The value of the objective among a point's scalars.

    Raises:
        ConfigError: the point has no such scalar.
    """
    if name not in scalars:
        raise ConfigError.at("objective", name, f"a point such as this one has none, only {', '.join(scalars)}")
    return scalars[name]
