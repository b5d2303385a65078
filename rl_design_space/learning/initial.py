"""What a Q-matrix begins with."""

from __future__ import annotations

import math

from rl_design_space.design import DesignPoint, OptimisticValues
from rl_design_space.design.identity import full_name
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked import rewards


def initial_value(point: DesignPoint) -> float:
    """Return the value that a Q-matrix begins with.

    Raises:
        ConfigError: the exploration gives none that is finite.
    """
    if not isinstance(point.exploration, OptimisticValues):
        return point.learner.initial_q
    value = point.exploration.initial_q(rewards(point), point.task.goals)
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        name = full_name(type(point.exploration))
        raise ConfigError(f"exploration: {name}.initial_q() should give a finite number, not {value!r}")
    return float(value)
