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
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from rl_design_space._arrays import FloatArray

#: Bootstrap samples of periods.
RESAMPLES = 1000
CONFIDENCE = 0.95
#: Probability with which the periods that are said to decide do decide, if the measured difference is the true one.
POWER = 0.8
#: Designs with the best values, to which all are compared first, and a quantile that is larger than any that is found.
_LEADERS, _FAR = 20, 6.0
#: Multiplications that are spent on the quantiles of designs; the designs after that get the largest quantile found.
_WORK = 4e8
#: Skew of a difference, over the root of the number of periods, below which it counts as symmetric.
_NO_SKEW = 1e-6


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
) -> BestSet:
    """Return which designs cannot be told from the best.

    Args:
        value: (designs,)
        samples: (resamples, designs) values of resampled periods, the same periods in all designs.
        each: (periods, designs) of which values are means; None if they are means of none. The quantile is then that of
            the resampled differences.
        periods: number of periods.
        largest_is_best: whether a large value is good.
    """
    if largest_is_best:
        value, samples, each = -value, -samples, None if each is None else -each
    centred = None if each is None else np.asarray(each - each.mean(axis=0), np.float32)
    drawn = samples - value if centred is None else _multiplied(centred)
    leader = int(value.argmin())
    order = np.argsort(value, kind="stable")
    doubt = np.full(len(value), -np.inf)  # how much further another design is better than the bound reaches
    for other in order[:_LEADERS].tolist():
        error, skew = _spread(samples, centred, other)
        doubt = np.maximum(doubt, value - value[other] - error * _reach(_FAR, -skew))
    near = np.flatnonzero(doubt <= 0)
    near = near[np.argsort(value[near], kind="stable")]
    exact = max(1, int(_WORK / (drawn.size + samples.size)))
    inside = np.zeros(len(value), dtype=bool)
    loss = np.zeros(len(value))
    decided = np.full(len(value), np.nan)
    quantile = 0.0
    for count, design in enumerate(near.tolist()):
        error, skew = _spread(samples, centred, design)
        if count < exact:
            largest = _ratio(np.asarray(drawn - drawn[:, [design]], np.float64), error).max(axis=1)
            found = max(0.0, float(np.quantile(largest, CONFIDENCE)))
            quantile = max(quantile, found)
        else:
            found = quantile
        reach = error * _reach(found, skew)
        bound = value - value[design] + reach
        bound[design] = 0
        if (bound >= 0).all():
            inside[design] = True
            loss = np.maximum(loss, bound)
            gap = value[design] - value[leader]
            if gap > 0:
                decided[design] = np.ceil(
                    periods * ((reach[leader] + stats.norm.ppf(POWER) * error[leader]) / gap) ** 2
                )
            elif design != leader:
                decided[design] = np.inf
    least = samples == samples.min(axis=1, keepdims=True)
    probability = (least / least.sum(axis=1, keepdims=True)).mean(axis=0)
    return BestSet(inside, loss, probability, decided, leader)


def _multiplied(centred: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return (draws, designs) normal variables with the covariances of the means, of (periods, designs) deviations."""
    periods = len(centred)
    multipliers = np.random.default_rng(0).standard_normal((RESAMPLES, periods))
    multipliers -= multipliers.mean(axis=1, keepdims=True)
    return np.asarray(multipliers.astype(np.float32) @ centred / np.float32(periods))


def _spread(samples: FloatArray, centred: NDArray[np.float32] | None, design: int) -> tuple[FloatArray, FloatArray]:
    """Return the standard errors of the differences of all designs from one, and the skew of their means.

    Args:
        samples: (resamples, designs) resampled values.
        centred: (periods, designs) deviations from the means; None if values are means of none. No skew is known then.
        design: whose values are subtracted.
    """
    if centred is None:
        return (samples - samples[:, [design]]).std(axis=0, ddof=1), np.zeros(samples.shape[1])
    periods = len(centred)
    away = centred - centred[:, [design]]
    squares = away * away
    second = squares.mean(axis=0, dtype=np.float64)
    squares *= away
    skew = _ratio(squares.mean(axis=0, dtype=np.float64), second**1.5) / np.sqrt(periods)
    return np.sqrt(second / (periods - 1)), skew


def _reach(quantile: float, skew: FloatArray) -> FloatArray:
    """Return the number of standard errors that a bound lies above each difference.

    Args:
        quantile: the number for a difference without skew.
        skew: of the mean differences.
    """
    skew = np.where(np.abs(skew) < _NO_SKEW, _NO_SKEW, skew)
    return np.asarray(np.maximum(quantile, 3 / skew * (1 - np.cbrt(1 - skew * (quantile + skew / 6)))))


def _ratio(away: FloatArray, error: FloatArray) -> FloatArray:
    """Return away / error; 0 where both are 0, infinity with the sign of `away` where only the error is."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.asarray(away / error)
    return np.where(np.isnan(ratio), 0.0, ratio)
