"""Comparison of measured values with published ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import mean_estimate, share_estimate, top_percent_weight

#: What `compare_with_published` returns, in this order.
COLUMNS = (
    "paper", "measured", "ci_low", "ci_high", "ratio", "failed_periods", "failed_low", "failed_high", "top_percent"
)  # fmt: skip


def compare_with_published(
    published: float, values: FloatArray | None = None, failed: NDArray[np.bool_] | None = None
) -> dict[str, float]:
    """Return a published value and what was measured for it.

    Args:
        published: the value.
        values: (periods,) whose mean is the measured value; None if nothing was measured.
        failed: (periods,) whether a trial missed the goal.

    Returns:
        `paper`, the published value; `measured` (mean over periods), `ci_low`, `ci_high` (95 %), `ratio` (measured /
        published), `failed_periods` (share) with `failed_low`, `failed_high` (95 %, Wilson), and `top_percent` (see
        `statistics.top_percent_weight`): all NaN if nothing was measured.
    """
    if values is None or failed is None:
        return {**dict.fromkeys(COLUMNS, math.nan), "paper": published}
    mean = mean_estimate(values)
    numbers = (published, *mean, mean.value / published, *share_estimate(failed), top_percent_weight(values))
    return dict(zip(COLUMNS, numbers, strict=True))
