"""Whether peers do the same job: their mean total steps agree within what chance allows.

A period's total steps depend much on its layout, and all peers get the same layouts, so periods are compared in
pairs: t is the mean difference from ours over its standard error. A peer disagrees if a difference as large as its
own has, were the jobs equal, a probability below 0.1 % divided by the number of comparisons (Bonferroni), so a race
of equal jobs has a peer declared void by chance once in a thousand.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from benchmarks.peers import OURS

#: Probability that any peer of a race is declared void although all do the same job.
FALSE_ALARM = 1e-3

#: Total steps of every period, by the seed of its layouts.
Totals = Mapping[int, NDArray[np.int64]]


@dataclass(frozen=True)
class Agreement:
    """How a peer's total steps compare with ours.

    Attributes:
        periods: that both learned.
        mean: total steps a period of the peer, and its standard error `sem`.
        difference: (peer - ours) / ours.
        detectable: the smallest absolute difference that would have been noticed.
        t: difference in its standard errors.
        agrees: whether that may be chance.
    """

    periods: int
    mean: float
    sem: float
    difference: float
    detectable: float
    t: float
    agrees: bool


def compare(totals: Mapping[str, Totals]) -> dict[str, Agreement]:
    """Compare every peer with ours.

    Raises:
        ValueError: a peer has fewer than two periods in common with ours.
    """
    level = FALSE_ALARM / max(1, len(totals) - 1)
    return {name: _compare(name, peer, totals[OURS], level) for name, peer in totals.items()}


def _compare(name: str, peer: Totals, ours: Totals, level: float) -> Agreement:
    pairs = [_in_pairs(peer[seed], ours[seed]) for seed in peer if seed in ours]
    if sum(len(theirs) for theirs, _ in pairs) < 2:
        raise ValueError(f"{name}: fewer than two periods to compare with {OURS}")
    theirs, own = (np.concatenate(side).astype(np.float64) for side in zip(*pairs, strict=True))
    periods = len(theirs)
    difference = theirs - own
    error = difference.std(ddof=1) / np.sqrt(periods)
    mean = difference.mean()
    # No spread at all: the very same steps, or a constant offset that is no chance.
    t = mean / error if error > 0 else (0.0 if mean == 0 else np.copysign(np.inf, mean))
    critical = stats.t.isf(level / 2, periods - 1)
    return Agreement(
        periods=periods,
        mean=float(theirs.mean()),
        sem=float(theirs.std(ddof=1) / np.sqrt(periods)),
        difference=float(mean / own.mean()),
        detectable=float(critical * error / own.mean()),
        t=float(t),
        agrees=bool(abs(t) <= critical),
    )


def _in_pairs(theirs: NDArray[np.int64], own: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first periods of a seed have the same layouts, however many follow."""
    common = min(len(theirs), len(own))
    return theirs[:common], own[:common]
