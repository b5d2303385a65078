"""Names of what a design point yields."""

#: Recorded for every point.
CURVES = ("steps/mean", "steps/median", "success_rate")
#: Recorded if asked for; every run's artifact holds them anyway.
CURVES_ON_DEMAND = ("steps/q10", "steps/q90", "steps/over_optimum", "epsilon")
#: The numbers that sum a point up, see `LearningCurves.scalars`.
SCALARS = (
    "total_steps",
    "total_steps_sem",
    "total_steps_scaled",
    "failed_trials",
    "failed_periods",
    "final_steps_over_optimum",
    "env_steps_per_second",
)
