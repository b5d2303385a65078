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
periods that both have, and a tenth of the error is left to the looks at which others were stopped. A design with fewer
periods than others is left out as well if those that led before are better at this error (`analysis.leaders`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.columns import Columns
from rl_design_space.analysis.leaders import SHARE, behind_leaders
from rl_design_space.analysis.pairs import Pairs, PeriodPairs, ResampledPairs, ratio, reach
from rl_design_space.analysis.resampling import resample_weights

#: Bootstrap samples of periods.
RESAMPLES = 1000
CONFIDENCE = 0.95
#: Share of the error that remains for designs with unequal numbers of periods: a race has spent the rest.
LAST_SHARE = 0.9
#: Probability with which the periods that are said to decide do decide, if the measured difference is the true one.
POWER = 0.8
#: Designs with the best values, to which all are compared first, and factor that makes the quantile of independent
#: differences larger than any that is found.
_LEADERS, _LARGER = 20, 1.1
#: Multiplications that are spent on the quantiles of designs; the designs after that get the largest quantile found.
_WORK = 4e8
#: The normal distribution without SciPy, whose import takes longer than the comparison of a hundred designs.
_NORMAL = NormalDist()


@dataclass(frozen=True)
class BestSet:
    """Designs compared with the best of them; arrays are (designs,).

    Attributes:
        inside: whether the design cannot be told from the best.
        loss_at_most: how much worse than the best it is at most, all together with 95 %.
        probability: share of the resamples in which it is the best; ties are divided.
        periods: number of periods after which the design would probably be left out, if what was measured is true;
            infinity if it is equal to the best, NaN of the best itself and of those that are left out.
        leader: index of the design with the best value, of those with the most periods.
    """

    inside: NDArray[np.bool_]
    loss_at_most: FloatArray
    probability: FloatArray
    periods: FloatArray
    leader: int


def best_set(
    value: FloatArray,
    samples: FloatArray,
    each: Columns | FloatArray | None = None,
    *,
    periods: int,
    largest_is_best: bool = False,
    confidence: float = CONFIDENCE,
) -> BestSet:
    """Return which designs cannot be told from the best.

    Args:
        value: (designs,)
        samples: (resamples, designs) values of resampled periods, the same periods in all designs that have the same.
        each: (periods, designs) of which values are means, as columns or as an array with NaN where a design does not
            have a period; None if they are means of none. The quantile is then that of the resampled differences.
        periods: number of periods.
        largest_is_best: whether a large value is good.
        confidence: with which the true best is in the set.
    """
    if isinstance(each, np.ndarray):
        each = Columns.of_array(each)
    if largest_is_best:
        value, samples, each = -value, -samples, None if each is None else -each
    unequal = each is not None and not each.is_even
    error_left = (1 - confidence) * (LAST_SHARE if unequal else 1)
    designs, outlying = len(value), np.zeros(0, dtype=np.intp)
    pairs: Pairs
    if each is None:
        pairs = ResampledPairs(value, samples, periods)
    else:
        both, outlying = each.with_cut()
        pairs = PeriodPairs(both, RESAMPLES)
    order = pairs.ranked[pairs.ranked < designs]
    leader = int(order[0])
    far = _LARGER * _NORMAL.inv_cdf(1 - error_left / (2 * designs))
    # How much further another design is better than the bound reaches.
    doubt = np.full(designs + len(outlying), -np.inf)
    for other in order[:_LEADERS].tolist():
        error, skew = pairs.spread(other)
        doubt = np.maximum(doubt, pairs.differences(other) - error * reach(far, -skew))
    doubt[outlying] = np.maximum(doubt[outlying], doubt[designs:])
    near = np.flatnonzero(doubt[:designs] <= 0)
    if unequal and each is not None:
        near = near[~_stopped(each, (1 - confidence) * (1 - LAST_SHARE))[near]]
    near = near[np.argsort(value[near], kind="stable")]
    exact = max(1, int(_WORK / (RESAMPLES * designs + samples.size)))
    inside = np.zeros(designs, dtype=bool)
    loss = np.zeros(designs)
    first, quantile = -1, 0.0
    #: Periods to decide between a design and the leader, or the first of the set.
    decided = np.full((2, designs), np.nan)
    for count, design in enumerate(near.tolist()):
        #: The design as it is, and without its far outliers.
        forms = [design, *(designs + np.flatnonzero(outlying == design)).tolist()]
        spreads = [[part[:designs] for part in pairs.spread(form)] for form in forms]
        if count < exact:
            found = _quantile(pairs, forms, design, [error for error, _ in spreads], error_left)
            quantile = max(quantile, found)
        else:
            found = quantile
        away = [error * reach(found, skew) for error, skew in spreads]
        bounds = [pairs.differences(form)[:designs] + width for form, width in zip(forms, away, strict=True)]
        bound = np.min(bounds, axis=0)
        bound[design] = 0
        if (bound >= 0).all():
            inside[design] = True
            loss = np.maximum(loss, bound)
            first = design if first < 0 else first
            for of, other in zip(decided, (leader, first), strict=True):
                gap = away[0][other] - bounds[0][other]
                if gap > 0:
                    wide = away[0][other] + _NORMAL.inv_cdf(POWER) * spreads[0][0][other]
                    of[design] = np.ceil(pairs.periods(design)[other] * (wide / gap) ** 2)
                elif design != other:
                    of[design] = np.inf
    if unequal and each is not None:
        samples = _of_common_periods(each, inside)
    least = samples == samples.min(axis=1, keepdims=True)
    probability = (least / least.sum(axis=1, keepdims=True)).mean(axis=0)
    # A leader that has the most periods may be worse than others.
    return BestSet(inside, loss, probability, decided[0 if inside[leader] else 1], leader)


def best_means(each: FloatArray, confidence: float = CONFIDENCE) -> BestSet:
    """Return which designs cannot be told from the one with the smallest mean, see `best_set`.

    Args:
        each: (periods, designs), NaN where a design does not have a period.
        confidence: with which the true best is in the set.
    """
    samples = resample_weights(len(each), 0, RESAMPLES) @ np.nan_to_num(each)
    return best_set(np.nanmean(each, axis=0), samples, each, periods=len(each), confidence=confidence)


def _quantile(pairs: Pairs, forms: Sequence[int], design: int, errors: Sequence[FloatArray], level: float) -> float:
    """Return the number of standard errors within which all differences from a design are, but for this share.

    Args:
        pairs: the designs.
        forms: the design, and the same without its far outliers.
        design: its index.
        errors: standard errors of the differences from each form, (designs,).
        level: the share.
    """
    largest = np.zeros(1)
    for form, error in zip(forms, errors, strict=True):
        drawn = pairs.drawn(form)[:, : len(error)]
        drawn[:, design] = 0
        largest = np.maximum(largest, ratio(drawn, error).max(axis=1))
    return float(np.quantile(largest, 1 - level))


def _stopped(each: Columns, error: float) -> NDArray[np.bool_]:
    """Return which designs have fewer periods than others and are behind those that led before, (designs,)."""
    counts = each.counts
    return np.asarray((counts < counts.max()) & behind_leaders(each, error * SHARE))


def _of_common_periods(each: Columns, designs: NDArray[np.bool_]) -> FloatArray:
    """Return (resamples, designs) means of resampled periods that these designs have in common; infinity of others."""
    common = each.in_common(np.flatnonzero(designs))
    samples = np.full((RESAMPLES, len(designs)), np.inf)
    samples[:, designs] = resample_weights(len(common), 0, RESAMPLES) @ common
    return samples
