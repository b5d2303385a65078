"""Statistics tested against the ranges that claims give for them, singly and combined."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds, known
from rl_design_space.analysis.statistics import percentile_interval


class Severity(NamedTuple):
    """How hard a test of a best value is to pass.

    Attributes:
        passing: how many of the other values of the grid would have passed the same test.
        others: how many other values the grid has.
        is_near: whether the measure at the claimed value is in the range, whatever its interval.
        others_near: of how many of the other values that is so.
    """

    passing: int
    others: int
    is_near: bool
    others_near: int


@dataclass(frozen=True)
class Tested:
    """A statistic tested against the range that a claim gives for it.

    Attributes:
        what: description of the statistic.
        low, high: the range, both ends included.
        value: measured value; its bound if it is censored.
        ci_low, ci_high: its 95 % bootstrap interval over periods.
        p_claim: probability of such data if the claim does not hold: share of resamples outside of the range.
        p_other: probability of such data if the claim holds: share of resamples inside.
        sign: `≥` or `≤` if the value is censored, so that only a bound is known.
        severity: how many other values would have passed, if the part is about a best value.
        remarks: what a reader of the value should know, as phrases.
    """

    what: str
    low: float
    high: float
    value: float
    ci_low: float
    ci_high: float
    p_claim: float
    p_other: float
    sign: str = ""
    severity: Severity | None = None
    remarks: tuple[str, ...] = ()

    @property
    def state(self) -> str:
        """Whether the part `holds`, `fails`, or is `unclear`, according to its interval."""
        if self.low <= self.ci_low and self.ci_high <= self.high:
            return "holds"
        return "fails" if self.ci_high < self.low or self.ci_low > self.high else "unclear"

    def leaves(self) -> Iterator[tuple[str, Tested]]:
        """Yield the statistics that were tested, each with its description after those of what combines it."""
        yield self.what, self

    def deciding(self) -> tuple[str, Tested]:
        """Return the statistic that decides, as `leaves` yields it."""
        return self.what, self


@dataclass(frozen=True, kw_only=True)
class Combined(Tested):
    """Several tested parts, of which all or any must hold.

    Range, value and interval are those of the part that decides.

    Attributes:
        parts: what is combined.
        decisive: the part that decides.
        any_of: whether one part that holds is enough.
    """

    parts: tuple[Tested, ...]
    decisive: Tested
    any_of: bool

    @property
    def state(self) -> str:
        states = [part.state for part in self.parts]
        first, second = ("holds", "fails") if self.any_of else ("fails", "holds")
        if first in states:
            return first
        return second if set(states) == {second} else "unclear"

    def leaves(self) -> Iterator[tuple[str, Tested]]:
        for part in self.parts:
            for what, leaf in part.leaves():
                yield f"{self.what}: {what}", leaf

    def deciding(self) -> tuple[str, Tested]:
        what, leaf = self.decisive.deciding()
        return f"{self.what}: {what}", leaf


def in_range(what: str, value: float, samples: FloatArray, low: float, high: float) -> Tested:
    """Test with bootstrap samples whether a statistic lies in a range.

    Args:
        what: description of the statistic.
        value: measured value.
        samples: (resamples,) bootstrap samples.
        low: lower end of the range; may be minus infinity.
        high: upper end of the range; may be infinity.
    """
    return bounds_in_range(what, known(np.array([value])), known(samples), low, high)


def bounds_in_range(what: str, value: Bounds, samples: Bounds, low: float, high: float) -> Tested:
    """Test whether a statistic lies in a range if only its bounds may be known, see `in_range`.

    A resample counts as inside or outside only if its bounds leave no doubt.

    Args:
        what: description of the statistic.
        value: (1,) bounds of the measured value.
        samples: (resamples,) bounds in each resample.
        low: lower end of the range.
        high: upper end of the range.
    """
    sign, shown = _shown(value)
    if np.isnan(samples.low).any() or np.isnan(samples.high).any() or math.isnan(shown):  # such as 0 / 0: undecided
        return Tested(what, low, high, shown, math.nan, math.nan, p_claim=1.0, p_other=1.0)
    inside = float(((samples.low >= low) & (samples.high <= high)).mean())
    not_outside = float(((samples.high >= low) & (samples.low <= high)).mean())
    least = least_chance(samples)
    chances = (max(1 - inside, least), max(not_outside, least))
    return Tested(what, low, high, shown, *interval(samples), *chances, sign=sign)


def exact(what: str, value: float, low: float, high: float) -> Tested:
    """Test a statistic that does not depend on chance."""
    holds = low <= value <= high
    return Tested(what, low, high, value, value, value, float(not holds), float(holds))


def never_or_always(tested: Tested, ci_low: float, ci_high: float) -> Tested:
    """Return the test of a share that is the same in every resample, with an interval that does not end there.

    Resamples of 0 in n are all 0. What that leaves open is undecided.

    Args:
        tested: the test by resampling.
        ci_low: lower end of the interval.
        ci_high: upper end of the interval.
    """
    widened = replace(tested, ci_low=ci_low, ci_high=ci_high)
    return replace(widened, p_claim=1.0, p_other=1.0) if widened.state == "unclear" else widened


def least_chance(samples: Bounds) -> float:
    """Return the smallest probability that these resamples can show; it is not 0."""
    return 1.0 / (int(samples.low.shape[-1]) + 1)


def interval(samples: Bounds) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a statistic of which only bounds may be known."""
    if np.array_equal(samples.low, samples.high) and np.isfinite(samples.low).all():
        low, high = percentile_interval(samples.low)
        return float(low), float(high)
    ends = (np.percentile(samples.low, 2.5, method="lower"), np.percentile(samples.high, 97.5, method="higher"))
    return float(ends[0]), float(ends[1])


def all_of(what: str, parts: Sequence[Tested]) -> Combined:
    """Combine parts that must all hold.

    That they do is the weakest part's to show (intersection–union test); that they do not, one part's (Bonferroni).
    """
    p_claim, p_other = all_chances(parts)
    holds = p_claim < p_other
    decisive = max(parts, key=lambda part: part.p_claim) if holds else min(parts, key=lambda part: part.p_other)
    return _combined(what, parts, decisive, p_claim, p_other, any_of=False)


def any_of(what: str, parts: Sequence[Tested]) -> Combined:
    """Combine parts of which one must hold.

    That none of them does takes the failure of all (intersection–union test); that one does, one part (Bonferroni).
    """
    p_claim = min(1.0, len(parts) * min(part.p_claim for part in parts))
    p_other = max(part.p_other for part in parts)
    holds = p_claim < p_other
    decisive = min(parts, key=lambda part: part.p_claim) if holds else max(parts, key=lambda part: part.p_other)
    return _combined(what, parts, decisive, p_claim, p_other, any_of=True)


def all_chances(parts: Sequence[Tested]) -> tuple[float, float]:
    """Return the error probabilities of several parts that must all hold, see `Tested.p_claim` and `Tested.p_other`."""
    return max(part.p_claim for part in parts), min(1.0, len(parts) * min(part.p_other for part in parts))


def every_in_range(what: str, value: Bounds, samples: Bounds, low: float, high: float) -> tuple[Tested, int]:
    """Test whether all of several statistics lie in one range; return the test and the index of the decisive one.

    That all do is an intersection–union test. That one does not is tested by the largest distance from the range, in
    standard errors, against that of the resamples from the measured values, so no correction for their number is due
    (single-step maximum; Westfall and Young, "Resampling-based multiple testing", 1993).

    Args:
        what: description of the statistics.
        value: (statistics, 1) bounds of the measured values.
        samples: (statistics, resamples) bounds in each resample.
        low: lower end of the range.
        high: upper end of the range.
    """
    rows = [bounds_in_range(what, value.row(index), samples.row(index), low, high) for index in range(len(value.low))]
    p_claim = max(row.p_claim for row in rows)
    p_other = min(1.0, len(rows) * min(row.p_other for row in rows))
    if np.array_equal(samples.low, samples.high) and np.isfinite(samples.low).all():
        p_other = max(_largest_distance(value.low, samples.low, low, high), least_chance(samples))
    order = range(len(rows))
    if any(row.state == "fails" for row in rows):
        decisive = max(order, key=lambda row: max(rows[row].ci_low - high, low - rows[row].ci_high))
    else:
        decisive = max(order, key=lambda row: (rows[row].p_claim, rows[row].ci_high - high, low - rows[row].ci_low))
    chosen = rows[decisive]
    ends = (chosen.value, chosen.ci_low, chosen.ci_high)
    return Tested(what, low, high, *ends, p_claim, p_other, sign=chosen.sign), decisive


def _largest_distance(value: FloatArray, samples: FloatArray, low: float, high: float) -> float:
    """Return how often resamples are as far from the measured values as the farthest of these is from the range."""
    if not (np.isfinite(low) or np.isfinite(high)):
        return 1.0
    error = samples.std(axis=1, keepdims=True)
    measured = np.maximum(value - high, low - value)
    if (certain := (error[:, 0] == 0)).any() and (measured[certain] > 0).any():
        return 0.0
    moved: NDArray[np.float64] = samples - value
    away = np.maximum(moved if np.isfinite(high) else -np.inf, -moved if np.isfinite(low) else -np.inf)
    error, away, measured = error[~certain], away[~certain], measured[~certain]
    return float(((away / error).max(axis=0) >= (measured / error).max()).mean()) if len(error) else 1.0


def _shown(value: Bounds) -> tuple[str, float]:
    """Return the value to show and the sign before it; NaN if nothing is known."""
    low, high = float(value.low[0]), float(value.high[0])
    if low == high or math.isnan(low) or math.isnan(high):
        return "", low if low == high else math.nan
    if math.isinf(high):
        return ("", math.nan) if math.isinf(low) else ("≥", low)
    return "≤", high


def _combined(
    what: str, parts: Sequence[Tested], decisive: Tested, p_claim: float, p_other: float, any_of: bool
) -> Combined:
    return Combined(
        what=what, low=decisive.low, high=decisive.high, value=decisive.value, ci_low=decisive.ci_low,
        ci_high=decisive.ci_high, p_claim=p_claim, p_other=p_other, sign=decisive.sign,
        parts=tuple(parts), decisive=decisive, any_of=any_of,
    )  # fmt: skip
