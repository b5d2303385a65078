"""Designs compared with leaders that were chosen before the periods by which they are compared.

In each period, the leaders are the ⌈√m⌉ of the m designs that have the period with the least means over the periods
before it. If a design is the true best, its difference from the mean of the leaders is not above 0 on average,
whichever they are, because a mean of designs that are no better is no better. So the differences of all periods are
compared with 0 by one test for each design: that many designs could have led need not be paid for, as it has to be
where the leaders are chosen by the same periods. And the mean of several leaders varies less than one of them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.pairs import better, cut, groups

#: Periods by which the first leaders are chosen.
_CHOOSING = 5
#: Share of an error that this comparison gets; the rest is that of comparisons with single rivals.
SHARE = 0.5


def leading(each: FloatArray) -> FloatArray:
    """Return (periods,) the means of the leaders of each period; NaN for the first, by which none are chosen.

    Args:
        each: (periods, designs), a small number being good; NaN where a design does not have a period.
    """
    has = ~np.isnan(each)
    sums, counts = np.where(has, each, 0.0).cumsum(axis=0), has.cumsum(axis=0)
    found = np.full(len(each), np.nan)
    for period in range(_CHOOSING, len(each)):
        designs = np.flatnonzero(has[period] & (counts[period - 1] > 0))
        if len(designs):
            means = sums[period - 1, designs] / counts[period - 1, designs]
            first = np.argsort(means, kind="stable")[: math.ceil(math.sqrt(len(designs)))]
            found[period] = each[period, designs[first]].mean()
    return found


def behind_leaders(each: FloatArray, error: float) -> NDArray[np.bool_]:
    """Return which designs are worse than the leaders beyond doubt, (designs,).

    Args:
        each: (periods, designs), see `leading`.
        error: probability with which the true best is one of them.
    """
    # Not from `scipy.stats`, whose import takes a second. Here, because comparing designs without it needs no SciPy.
    from scipy.special import stdtrit

    found = np.zeros(each.shape[1], dtype=bool)
    leader = leading(each)
    known = ~np.isnan(leader)
    leader, each = leader[known], each[known]
    patterns, group = groups(~np.isnan(each))
    for number, pattern in enumerate(patterns):
        rows, members = np.flatnonzero(pattern), np.flatnonzero(group == number)
        if len(rows) < 2:
            continue
        own = each[np.ix_(rows, members)]
        less, outlying = cut(own)
        errors = np.full(len(members), error)
        errors[outlying] /= 2  # for two comparisons
        quantile = -stdtrit(len(rows) - 1, errors)
        found[members] |= better(leader, rows, own, quantile)
        found[members[outlying]] |= better(leader, rows, less, quantile[outlying])
    return found
