"""Results as tidy pandas frames, and as text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rl_design_space.learning.measure_functions import FINAL_TRIALS
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


def text_of(result: Any, error: float | None, final: float) -> str:
    """Return a `LearningCurves` in words.

    Args:
        result: the result.
        error: standard error of its total steps; None of one period.
        final: steps / optimum in the final trials.
    """
    periods, trials = result.steps.shape
    stages = " + ".join(str(stage.trials) for stage in result.stages)
    solved = int(result.success.all(axis=1).sum())
    lines = (
        f"LearningCurves of {periods} periods × {trials} trials{f', in stages of {stages}' if stages else ''}",
        f"  total steps   {result.total_steps.mean():,.0f}"
        f"{'' if error is None else f' ± {error:,.0f} (standard error)'} a period",
        f"  success       {result.success.mean():.2%} of trials; every trial in {solved} of {periods} periods",
        f"  final policy  {final:.2f} × the optimum, last {min(FINAL_TRIALS, trials)} trials",
        f"  seconds       {result.seconds:.3f}",
    )
    return "\n".join(lines)
