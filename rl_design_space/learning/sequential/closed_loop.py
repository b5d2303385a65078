"""Levels of exploration that follow how a period goes: a compiled function gives the level of the next trial."""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.compiled import compiled
from rl_design_space.learning.sequential.own import call_address


@compiled
def level_after(behaviour, trial, level, successes, succeeded, steps, error):
    """Return ε of a trial after the one before it; the caller says what is done if it is not within 0 and 1."""
    parameters = behaviour.parameters
    counters = float(trial), float(level), float(successes), float(int(succeeded)), float(steps), float(error)
    numbers = np.int64(parameters.ctypes.data), np.int64(len(parameters))
    return call_address(behaviour.rule, counters + numbers)
