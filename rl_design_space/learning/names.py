"""Names of the learning curves."""

#: Recorded for every point.
CURVES = ("steps/mean", "steps/median", "success_rate")
#: Recorded if asked for; every run's artifact holds them anyway.
CURVES_ON_DEMAND = ("steps/q10", "steps/q90", "steps/over_optimum", "epsilon")
