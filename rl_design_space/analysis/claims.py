"""Verdicts on claims: tests of their parts, and decisions on all claims of a study."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import percentile_interval

#: Probability of any wrong verdict among the claims of a study.
ERROR = 0.05


class Verdict(StrEnum):
    """Verdict of the measurements on a claim."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Tested:
    """A statistic tested against the range that a claim gives for it.

    Attributes:
        what: description of the statistic.
        low, high: the range, both ends included.
        value: measured value.
        ci_low, ci_high: its 95 % bootstrap interval over periods.
        p_claim: probability of such data if the claim does not hold: share of resamples outside of the range.
        p_other: probability of such data if the claim holds: share of resamples inside.
    """

    what: str
    low: float
    high: float
    value: float
    ci_low: float
    ci_high: float
    p_claim: float
    p_other: float

    @property
    def state(self) -> str:
        """Whether the part `holds`, `fails`, or is `unclear`, according to its interval."""
        if self.low <= self.ci_low and self.ci_high <= self.high:
            return "holds"
        return "fails" if self.ci_high < self.low or self.ci_low > self.high else "unclear"


def in_range(what: str, value: float, samples: FloatArray, low: float, high: float) -> Tested:
    """Test with bootstrap samples whether a statistic lies in a range.

    Args:
        what: description of the statistic.
        value: measured value.
        samples: (resamples,) bootstrap samples.
        low: lower end of the range; may be minus infinity.
        high: upper end of the range; may be infinity.
    """
    if np.isnan(samples).any() or math.isnan(value):  # such as 0 / 0: undecided
        return Tested(what, low, high, value, math.nan, math.nan, p_claim=1.0, p_other=1.0)
    inside = float(((samples >= low) & (samples <= high)).mean())
    least = 1 / (len(samples) + 1)  # resampling cannot prove a probability of 0
    ci_low, ci_high = percentile_interval(samples)
    chances = (max(1 - inside, least), max(inside, least))
    return Tested(what, low, high, value, float(ci_low), float(ci_high), *chances)


def exact(what: str, value: float, low: float, high: float) -> Tested:
    """Test a statistic that does not depend on chance."""
    holds = low <= value <= high
    return Tested(what, low, high, value, value, value, float(not holds), float(holds))


@dataclass(frozen=True)
class Finding:
    """The result of judging a claim.

    Attributes:
        verdict: on the claim.
        p: probability of a wrong verdict, adjusted by Holm's procedure; NaN if nothing was measured.
        decisive: the part that decides the verdict; None if nothing was measured.
        parts: all parts of the claim.
    """

    verdict: Verdict
    p: float
    decisive: Tested | None
    parts: Sequence[Tested]


def judge(claims: Mapping[str, Sequence[Tested]]) -> dict[str, Finding]:
    """Judge the claims of one study; return findings by name.

    A claim holds if all of its parts hold, and fails if any part fails (Bonferroni over the parts). A verdict requires
    a two-sided error probability below 5 % after Holm's correction over the claims (Scand. J. Statist. 6, 1979).

    Args:
        claims: the tested parts of each claim; none if nothing was measured.
    """
    chances = {name: _chances(parts) for name, parts in claims.items() if parts}
    adjusted = holm({name: min(1.0, 2 * min(both)) for name, both in chances.items()})
    findings = {}
    for name, parts in claims.items():
        if not parts:
            findings[name] = Finding(Verdict.UNDECIDED, math.nan, None, ())
            continue
        p_claim, p_other = chances[name]
        holds = p_claim < p_other
        decided = Verdict.REPRODUCED if holds else Verdict.NOT_REPRODUCED
        # A claim that holds is decided by its weakest part; one that fails, by the part that fails most clearly.
        decisive = max(parts, key=lambda part: part.p_claim) if holds else min(parts, key=lambda part: part.p_other)
        verdict = decided if adjusted[name] < ERROR else Verdict.UNDECIDED
        findings[name] = Finding(verdict, adjusted[name], decisive, tuple(parts))
    return findings


def holm(chances: Mapping[str, float]) -> dict[str, float]:
    """Return error probabilities adjusted by Holm's step-down procedure."""
    ranked = sorted(chances, key=lambda name: chances[name])
    scaled = [min(1.0, (len(ranked) - rank) * chances[name]) for rank, name in enumerate(ranked)]
    return dict(zip(ranked, np.maximum.accumulate(scaled).tolist(), strict=True)) if ranked else {}


def _chances(parts: Sequence[Tested]) -> tuple[float, float]:
    return max(part.p_claim for part in parts), min(1.0, len(parts) * min(part.p_other for part in parts))
