"""What a design point yields: steps of every trial of every period, and what is read off them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray

if TYPE_CHECKING:
    import pandas as pd

#: Trials at the end of a period that stand for the final policy.
FINAL_TRIALS = 10


@dataclass(frozen=True, eq=False)
class LearningCurves:
    """The learning curves of one design point, all periods apart.

    Attributes:
        steps: (periods, trials) int32, primitive moves until the final goal; the step cap where it was missed.
        success: (periods, trials) bool, whether the final goal was reached.
        optimum: (periods,) int32, fewest moves possible.
        rows: (periods, 2) int32, rows of the Q-matrix, one an observation that a period can meet, and those of them
            that anything was learned for: an action has another value than at the start.
        epsilon: (trials,) float64, the exploration schedule.
        seconds: wall time of learning.
    """

    steps: NDArray[np.int32]
    success: NDArray[np.bool_]
    optimum: NDArray[np.int32]
    rows: NDArray[np.int32]
    epsilon: FloatArray
    seconds: float

    def __repr__(self) -> str:
        periods, trials = self.steps.shape
        error = f" ± {self.total_steps.std(ddof=1) / np.sqrt(periods):,.0f} (standard error)" if periods > 1 else ""
        solved = int(self.success.all(axis=1).sum())
        last = min(FINAL_TRIALS, trials)
        lines = (
            f"LearningCurves of {periods} periods × {trials} trials",
            f"  total steps   {self.total_steps.mean():,.0f}{error} a period",
            f"  success       {self.success.mean():.2%} of trials; every trial in {solved} of {periods} periods",
            f"  final policy  {self.over_optimum[-FINAL_TRIALS:].mean():.2f} × the optimum, last {last} trials",
            f"  seconds       {self.seconds:.3f}",
        )
        return "\n".join(lines)

    @cached_property
    def total_steps(self) -> FloatArray:
        """(periods,) primitive moves of a whole period, failed trials included at the step cap."""
        total: FloatArray = self.steps.sum(axis=1, dtype=np.float64)
        return total

    @property
    def over_optimum(self) -> FloatArray:
        """(trials,) mean over periods of steps / optimum."""
        ratio: FloatArray = (self.steps / self.optimum[:, np.newaxis]).mean(axis=0)
        return ratio

    @cached_property
    def curves(self) -> dict[str, FloatArray]:
        """Every learning curve by its name, each (trials,)."""
        q10, median, q90 = np.quantile(self.steps, (0.1, 0.5, 0.9), axis=0)
        return {
            "steps/mean": self.steps.mean(axis=0),
            "steps/median": median,
            "steps/q10": q10,
            "steps/q90": q90,
            "steps/over_optimum": self.over_optimum,
            "success_rate": self.success.mean(axis=0),
            "epsilon": self.epsilon,
        }

    def to_frame(self, *, periods: bool = False) -> pd.DataFrame:
        """A tidy frame.

        Args:
            periods: one row a period and trial, instead of one row a trial.

        Returns:
            trial and every learning curve by its name; or period, trial, steps, success, the period's optimum, and
            epsilon, the periods one after the other.
        """
        import pandas as pd

        n_periods, n_trials = self.steps.shape
        trial = np.arange(n_trials)
        if not periods:
            return pd.DataFrame({"trial": trial, **self.curves})
        return pd.DataFrame(
            {
                "period": np.repeat(np.arange(n_periods), n_trials),
                "trial": np.tile(trial, n_periods),
                "steps": self.steps.ravel(),
                "success": self.success.ravel(),
                "optimum": np.repeat(self.optimum, n_trials),
                "epsilon": np.tile(self.epsilon, n_periods),
            }
        )

    def scalars(self, shape: tuple[int, int]) -> dict[str, float]:
        """The numbers that sum a point up; those that do not exist (a sem of one period) are left out.

        Args:
            shape: of the world, cells along x and y.

        Returns:
            total_steps: mean over periods of the primitive moves of all trials.
            total_steps_sem: its standard error.
            total_steps_scaled: total_steps · 10/d, moves of equal length on square grids of any size d (Table 4).
            failed_trials, failed_periods: share of trials, and of periods with a trial, that missed the final goal.
            final_steps_over_optimum: mean of steps / optimum over the last `FINAL_TRIALS` trials.
            env_steps_per_second: primitive moves learned a second.
        """
        periods = len(self.steps)
        values = {
            "total_steps": self.total_steps.mean(),
            "failed_trials": 1 - self.success.mean(),
            "failed_periods": 1 - self.success.all(axis=1).mean(),
            "final_steps_over_optimum": self.over_optimum[-FINAL_TRIALS:].mean(),
            "env_steps_per_second": self.total_steps.sum() / self.seconds,
        }
        if periods > 1:
            values["total_steps_sem"] = self.total_steps.std(ddof=1) / np.sqrt(periods)
        if shape[0] == shape[1]:
            values["total_steps_scaled"] = scaled_to_equal_steps(values["total_steps"], shape[0])
        return {name: float(value) for name, value in values.items()}


def scaled_to_equal_steps(steps: Any, side: Any) -> Any:
    """Moves on a d×d grid in units of moves on a 10×10 grid of the same extent: divided by d/10 (Table 4)."""
    return steps * 10 / side
