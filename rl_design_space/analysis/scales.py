"""Scales: what a period counts as in a decomposition of variance; shares depend on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.measures import Periods


@dataclass(frozen=True)
class Scale:
    """A number of each period that is made of its steps a trial.

    Attributes:
        brief: what it is, for headings and axes.
        meaning: what it is, as a noun phrase.
        of: of (periods, …) mean steps of a trial and the optimum of each period, in the same shape.
        is_log: whether a difference is the logarithm of a ratio.
    """

    brief: str
    meaning: str
    of: Callable[[FloatArray, NDArray[Any]], FloatArray]
    is_log: bool = False

    def each(self, periods: Periods) -> FloatArray:
        """Return (periods,) the number of each period."""
        return self.of(periods.total_steps / periods.steps.shape[1], periods.optimum)

    def by_trial(self, periods: Periods, bins: int) -> FloatArray:
        """Return (periods, bins) the number of each period in bins of neighbouring trials, as equal as possible."""
        edges = trial_edges(periods.steps.shape[1], bins)
        sums = np.add.reduceat(periods.steps, edges[:-1], axis=1, dtype=np.float64)
        return self.of(sums / np.diff(edges), periods.optimum[:, np.newaxis])


def trial_edges(trials: int, bins: int) -> NDArray[np.intp]:
    """Return (bins + 1,) the first trial of each bin, and the number of trials."""
    return np.linspace(0, trials, min(bins, trials) + 1).round().astype(np.intp)


#: Scales by name.
SCALES: Mapping[str, Scale] = {
    "log_over_optimum": Scale(
        "log(steps / optimum)",
        "log(total steps of a period / (trials · optimum of that period))",
        lambda steps, optimum: np.log(steps / optimum),
        is_log=True,
    ),
    "over_optimum": Scale(
        "steps / optimum",
        "total steps of a period / (trials · optimum of that period)",
        lambda steps, optimum: steps / optimum,
    ),
    "log_steps": Scale(
        "log(steps)",
        "log(total steps of a period / trials)",
        lambda steps, optimum: np.log(steps + 0 * optimum),
        is_log=True,
    ),
}
#: The scale of decompositions unless another is asked for.
USUAL = "log_over_optimum"


def in_brief(name: str) -> str:
    """Return how a scale reads in headings and beside axes; a measure by its name."""
    return SCALES[name].brief if name in SCALES else name
