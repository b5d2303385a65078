"""Designs compared with leaders that were chosen before the periods by which they are compared.

In each period, the leaders are the ⌈√m⌉ of the m designs that have the period with the least means over the periods
before it. If a design is the true best, its difference from the mean of the leaders is not above 0 on average,
whichever they are, because a mean of designs that are no better is no better. So the differences of all periods are
compared with 0 by one test for each design: that many designs could have led need not be paid for, as it has to be
where the leaders are chosen by the same periods. And the mean of several leaders varies less than one of them.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.columns import Columns, cut
from rl_design_space.analysis.pairs import better

#: Periods by which the first leaders are chosen.
_CHOOSING = 5
#: Share of an error that this comparison gets; the rest is that of comparisons with single rivals.
SHARE = 0.5


def leading(each: Columns) -> FloatArray:
    """Return (periods,) the means of the leaders of each period; NaN for the first, by which none are chosen.

    Args:
        each: numbers of designs, a small one being good.
    """
    found, sums = np.full(each.periods, np.nan), np.zeros(each.designs)
    for begin, stop in pairwise(_edges(each)):
        designs, counts, numbers = _between(each, begin, stop)
        if not len(designs):
            continue
        totals = np.vstack([sums[designs], numbers]).cumsum(axis=0)
        sums[designs] = totals[-1]
        old = np.flatnonzero(counts)
        if begin >= _CHOOSING and len(old):
            means = totals[:-1, old] / (counts[old] + np.arange(stop - begin)[:, np.newaxis])
            first = np.argsort(means, axis=1, kind="stable")[:, : math.ceil(math.sqrt(len(old)))]
            found[begin:stop] = np.take_along_axis(numbers, old[first], axis=1).mean(axis=1)
    return found


def _edges(each: Columns) -> list[int]:
    """Return the periods between which the same designs have periods, and the same had one before."""
    changed = np.flatnonzero((each.has[:, 1:] != each.has[:, :-1]).any(axis=0)) + 1
    second = each.has.argmax(axis=1) + 1
    edges = np.minimum([0, _CHOOSING, *changed, *second, each.periods], each.periods)
    return sorted(set(edges.tolist()))


def _between(each: Columns, begin: int, stop: int) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray]:
    """Return the designs that have some periods, how many each had before, and their numbers, (periods, designs)."""
    blocks = [(block, int(np.searchsorted(block.rows, begin))) for block in each.blocks]
    blocks = [(block, before) for block, before in blocks if before < len(block.rows) and block.rows[before] == begin]
    if not blocks:
        return np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros((stop - begin, 0))
    designs = np.concatenate([block.designs for block, _ in blocks])
    counts = np.concatenate([np.full(len(block.designs), before) for block, before in blocks])
    numbers = np.hstack([block.numbers[before : before + stop - begin] for block, before in blocks])
    ordered = np.argsort(designs)
    return designs[ordered], counts[ordered], numbers[:, ordered]


def behind_leaders(each: Columns, error: float) -> NDArray[np.bool_]:
    """Return which designs are worse than the leaders beyond doubt, (designs,).

    Args:
        each: numbers of designs, see `leading`.
        error: probability with which the true best is one of them.
    """
    # Not from `scipy.stats`, whose import takes a second. Here, because comparing designs without it needs no SciPy.
    from scipy.special import stdtrit

    found = np.zeros(each.designs, dtype=bool)
    leader = leading(each)
    known = ~np.isnan(leader)
    places = known.cumsum() - 1
    leader = leader[known]
    for block in each.blocks:
        inside = known[block.rows]
        rows, own = places[block.rows[inside]], block.numbers[inside]
        if len(rows) < 2:
            continue
        less, outlying = cut(own)
        errors = np.full(len(block.designs), error)
        errors[outlying] /= 2  # for two comparisons
        quantile = -stdtrit(len(rows) - 1, errors)
        found[block.designs] |= better(leader, rows, own, quantile)
        found[block.designs[outlying]] |= better(leader, rows, less, quantile[outlying])
    return found
