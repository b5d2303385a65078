"""The objective: the scalar or measure that a run returns to a sweeper that optimizes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import SCALARS, values
from rl_design_space.learning.result import LearningCurves
from rl_design_space.tracking import Tracking
from rl_design_space.tracking.tracker import StoredRun


def objective_value(name: str, scalars: Mapping[str, float], result: Callable[[], LearningCurves]) -> float:
    """Return the value of the objective of a point.

    Args:
        name: of a scalar or measure.
        scalars: of the point.
        result: returns the result of the point, from which other measures are computed.

    Raises:
        ConfigError: the point has no such scalar, or the measure cannot be computed.
    """
    if name in scalars:
        return scalars[name]
    if name in SCALARS:
        raise ConfigError.at("objective", name, f"this point has no such scalar, only {', '.join(scalars)}")
    return values([name], result())[name]


def recorded_result(name: str, tracking: Tracking, run: StoredRun, point: DesignPoint) -> LearningCurves:
    """Return the result of a recorded point.

    Args:
        name: of the objective, for messages.
        tracking: where the run is recorded.
        run: the run.
        point: the point.

    Raises:
        ConfigError: the run has not been delivered yet, or did not keep its periods.
    """
    if not run.artifacts:
        reason = "is computed from the files of a run, which is not delivered yet; `rl-design-space sync` delivers it"
        raise ConfigError.at("objective", name, reason)
    arrays = tracking.reader().periods(run)
    if "steps" not in arrays:
        reason = f"run {run.run_id} kept its learning curves alone; needs tracking.artifact=periods"
        raise ConfigError.at("objective", name, reason)
    return LearningCurves.of_arrays(arrays, point)
