"""Results as tidy pandas frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rl_design_space.learning.stage_record import STAGE_CURVE, stage_curve

if TYPE_CHECKING:
    import pandas as pd


def frame_of(result: Any, *, periods: bool) -> pd.DataFrame:
    """Return a tidy frame of a `LearningCurves`, see its method `to_frame`."""
    import pandas as pd

    n_periods, n_trials = result.steps.shape
    trial = np.arange(n_trials)
    if not periods:
        return pd.DataFrame({"trial": trial, **result.curves})
    stage = {STAGE_CURVE: np.tile(stage_curve(result.stages).astype(int), n_periods)} if result.stages else {}
    return pd.DataFrame(
        {
            "period": np.repeat(np.arange(n_periods), n_trials),
            "trial": np.tile(trial, n_periods),
            "steps": result.steps.ravel(),
            "success": result.success.ravel(),
            "optimum": np.broadcast_to(result.optima, result.steps.shape).ravel(),
            "epsilon": np.tile(result.epsilon, n_periods),
            **stage,
        }
    )
