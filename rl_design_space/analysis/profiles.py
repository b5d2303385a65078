"""Performance profiles and the probability of improvement: how designs compare layout by layout.

Both are views of Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS 2021,
with the periods of a design as its tasks: a period has a layout of its own, which all designs meet.
"""

from __future__ import annotations

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import Estimate, percentile_interval, resampled_means

RESAMPLES = 2000


def profile(scores: FloatArray, levels: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the share of periods with a score up to each level, and the ends of its 95 % interval, (levels,) each.

    Args:
        scores: (periods,)
        levels: (levels,)
    """
    below = (scores[:, np.newaxis] <= levels).astype(np.float64)
    low, high = percentile_interval(resampled_means(below, 0, RESAMPLES))
    return below.mean(axis=0), low, high


def improvement(ours: FloatArray, theirs: FloatArray) -> Estimate:
    """Return the probability that a design needs less than another in the same layout; a tie counts half.

    Args:
        ours: (periods,) scores of the design, the smaller the better.
        theirs: scores of the other one in the same periods.
    """
    better = (ours < theirs) + 0.5 * (ours == theirs)
    low, high = percentile_interval(resampled_means(better, 0, RESAMPLES))
    return Estimate(float(better.mean()), float(low), float(high))
