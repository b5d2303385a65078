"""The designs that cannot be told from the best: multiple comparisons with the best.

A design is left out if some other one is better beyond doubt. For design i, all differences μ_j − μ_i are bounded
from above at once, all bounds together with 95 %; if one of them is below 0, i is not the best. So the true best is
left out in 5 % of cases at most, however many designs there are, and in the other cases no design is worse than the
best by more than its largest bound over the set: Hsu, "Constrained simultaneous confidence intervals for multiple
comparisons with the best", Ann. Statist. 12, 1984.

Differences are paired by period. How many standard errors hold them all together is the quantile of the largest of
normal variables that hang together as the differences do, drawn by multipliers of the periods: Chernozhukov,
Chetverikov and Kato, "Gaussian approximations and multiplier bootstrap for maxima of sums", Ann. Statist. 41, 2013.
Each bound is then moved outwards by the skew of its own difference (Hall, "On the removal of skewness by
transformation", JRSS B 54, 1992), so a design with a heavy tail widens its own bounds and not those of others.

Designs may have unequal numbers of periods, as after a race (`analysis.race`). Each pair is then compared over the
periods that both have, and a tenth of the error is left to the looks at which others were stopped.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.pairs import Pairs, PeriodPairs, ResampledPairs, ratio, reach

#: Bootstrap samples of periods.
RESAMPLES = 1000
CONFIDENCE = 0.95
#: Share of the error that remains for designs with unequal numbers of periods: a race has spent the rest.
LAST_SHARE = 0.9
#: Probability with which the periods that are said to decide do decide, if the measured difference is the true one.
POWER = 0.8
#: Designs with the best values, to which all are compared first, and a quantile that is larger than any that is found.
_LEADERS, _FAR = 20, 6.0
#: Multiplications that are spent on the quantiles of designs; the designs after that get the largest quantile found.
_WORK = 4e8


@dataclass(frozen=True)
class BestSet:
    """Designs compared with the best of them; arrays are (designs,).

    Attributes:
        inside: whether the design cannot be told from the best.
        loss_at_most: how much worse than the best it is at most, all together with 95 %.
        probability: share of the resamples in which it is the best; ties are divided.
        periods: number of periods after which the design would probably be left out, if what was measured is true;
            infinity if it is equal to the best, NaN of the best itself and of those that are left out.
        leader: index of the design with the best value.
    """

    inside: NDArray[np.bool_]
    loss_at_most: FloatArray
    probability: FloatArray
    periods: FloatArray
    leader: int


def best_set(
    value: FloatArray,
    samples: FloatArray,
    each: FloatArray | None = None,
    *,
    periods: int,
    largest_is_best: bool = False,
    confidence: float = CONFIDENCE,
) -> BestSet:
    """Return which designs cannot be told from the best.

    Args:
        value: (designs,)
        samples: (resamples, designs) values of resampled periods, the same periods in all designs that have the same.
        each: (periods, designs) of which values are means, NaN where a design does not have a period; None if they are
            means of none. The quantile is then that of the resampled differences.
        periods: number of periods.
        largest_is_best: whether a large value is good.
        confidence: with which the true best is in the set.
    """
    if largest_is_best:
        value, samples, each = -value, -samples, None if each is None else -each
    pairs: Pairs = ResampledPairs(value, samples, periods) if each is None else PeriodPairs(each, RESAMPLES)
    error_left = (1 - confidence) * (LAST_SHARE if each is not None and np.isnan(each).any() else 1)
    order = pairs.ranked
    leader = int(order[0])
    doubt = np.full(len(value), -np.inf)  # how much further another design is better than the bound reaches
    for other in order[:_LEADERS].tolist():
        error, skew = pairs.spread(other)
        doubt = np.maximum(doubt, pairs.differences(other) - error * reach(_FAR, -skew))
    near = np.flatnonzero(doubt <= 0)
    near = near[np.argsort(value[near], kind="stable")]
    exact = max(1, int(_WORK / (RESAMPLES * len(value) + samples.size)))
    inside = np.zeros(len(value), dtype=bool)
    loss = np.zeros(len(value))
    decided = np.full(len(value), np.nan)
    quantile = 0.0
    for count, design in enumerate(near.tolist()):
        error, skew = pairs.spread(design)
        if count < exact:
            largest = ratio(pairs.drawn(design), error).max(axis=1)
            found = max(0.0, float(np.quantile(largest, 1 - error_left)))
            quantile = max(quantile, found)
        else:
            found = quantile
        away = error * reach(found, skew)
        bound = pairs.differences(design) + away
        gap = away[leader] - bound[leader]
        bound[design] = 0
        if (bound >= 0).all():
            inside[design] = True
            loss = np.maximum(loss, bound)
            if gap > 0:
                common = pairs.periods(design)[leader]
                decided[design] = np.ceil(common * ((away[leader] + stats.norm.ppf(POWER) * error[leader]) / gap) ** 2)
            elif design != leader:
                decided[design] = np.inf
    samples = np.where(pairs.complete, samples, np.inf)
    least = samples == samples.min(axis=1, keepdims=True)
    probability = (least / least.sum(axis=1, keepdims=True)).mean(axis=0)
    return BestSet(inside, loss, probability, decided, leader)
