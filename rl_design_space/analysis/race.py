"""A race of designs: all begin with few periods, those that are worse beyond doubt stop, the others go on.

After certain numbers of periods, the looks, a design stops if one of those with the best values is better beyond
doubt, or the mean of those that led before is (`analysis.leaders`); each of the two has half of the error of the look.
The difference is paired by period; from one design it has to exceed the quantile of Student's t at this error over the
number of designs in the race, moved outwards by the skew of the difference (`analysis.best`). Errors of all looks add
up to the error of the race: the true best is stopped or left out of the final set in 5 % of cases at most, however
many designs and looks there are. Nine tenths of the error are left to the last look, so that its set (`best_set`) is
nearly that of designs which all have all periods. Designs that were stopped no longer count as rivals, because a tenth
of the error pays for having left them out (Romano, Shaikh and Wolf, Econometrica 82, 2014).

A design that has stopped goes on if the doubt returns: differences are measured again with the variance that its rivals
show in all their periods, so one that led because its rare long periods had not been met yet stops nobody for good.

Races without a bound on their error are F-Race and irace (Birattari et al., GECCO 2002; López-Ibáñez et al., Oper.
Res. Perspect. 3, 2016), which test at 5 % at every look. Hoeffding races (Maron and Moore, NIPS 1993) and betting
(Waudby-Smith and Ramdas, JRSS B 86, 2024) bound it without any assumption but the largest possible value, which is some
hundred times the mean here. Spending the error by looks is that of Lan and DeMets (Biometrika 70, 1983).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.best import CONFIDENCE, LAST_SHARE
from rl_design_space.analysis.columns import Columns, cut
from rl_design_space.analysis.leaders import SHARE, behind_leaders
from rl_design_space.analysis.pairs import better

#: Periods that all designs begin with, and factor from one look to the next.
FIRST, GROWTH = 20, 1.5
#: Designs with the best values, to which all others are compared.
_LEADERS = 20


class Look(NamedTuple):
    """A number of periods after which designs are compared.

    Attributes:
        periods: that those in the race have then.
        error: probability with which the true best is stopped at this look.
    """

    periods: int
    error: float


def looks(most: int, first: int = FIRST, growth: float = GROWTH, confidence: float = CONFIDENCE) -> tuple[Look, ...]:
    """Return the looks of a race; those before the last share a tenth of its error.

    Args:
        most: periods of a design that goes on to the end.
        first: periods of all designs.
        growth: factor from one look to the next.
        confidence: with which the true best is in the final set.
    """
    counts = [min(first, most)]
    while counts[-1] * growth**1.5 < most:  # no look shortly before the last
        counts.append(max(counts[-1] + 1, round(counts[-1] * growth)))
    if counts[-1] < most:
        counts.append(most)
    error, *before = 1 - confidence, *counts[:-1]
    early = [Look(count, error * (1 - LAST_SHARE) / len(before)) for count in before]
    return *early, Look(counts[-1], error * LAST_SHARE if early else error)


def behind(values: Sequence[FloatArray], look: Look) -> NDArray[np.bool_]:
    """Return which designs another one is better than beyond doubt, (designs,).

    Args:
        values: the numbers of the periods of each design, a small one being good; all are the first of one sequence.
            Those in the race have as many as the look; those that have stopped fewer.
        look: where the race is.
    """
    counts = np.array([len(each) for each in values])
    racing = np.flatnonzero(counts >= look.periods)
    means = np.array([values[design][: look.periods].mean() for design in racing.tolist()])
    leaders = racing[np.argsort(means, kind="stable")[:_LEADERS]]
    leading = np.stack([values[design][: look.periods] for design in leaders.tolist()], axis=1)
    until = [(np.arange(len(each))[: look.periods], each[: look.periods]) for each in values]
    found = behind_leaders(Columns.of_designs(until, look.periods), look.error * SHARE)
    for count in np.unique(np.minimum(counts, look.periods)).tolist():
        group = np.flatnonzero(np.minimum(counts, look.periods) == count)
        each = np.stack([values[design][:count] for design in group.tolist()], axis=1)
        less, outlying = cut(each)
        error = np.full(len(group), look.error * (1 - SHARE) / max(1, len(racing) - 1))
        error[outlying] /= 2  # for two comparisons
        quantile = -stdtrit(count - 1, error)
        for leader in leading.T:
            found[group] |= better(leader, np.arange(count), each, quantile)
            found[group[outlying]] |= better(leader, np.arange(count), less, quantile[outlying])
    return found


def matrix(values: Sequence[FloatArray]) -> FloatArray:
    """Return (periods, designs) the numbers of the periods of each design, NaN where it does not have a period."""
    each = np.full((max(map(len, values)), len(values)), np.nan)
    for design, numbers in enumerate(values):
        each[: len(numbers), design] = numbers
    return each
