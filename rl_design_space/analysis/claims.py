"""Verdicts on claims: what must hold, how surely it does, and what that means for all claims of a study."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.statistics import percentile_interval

#: Chance of a wrong verdict among the claims of a study.
ERROR = 0.05


class Verdict(StrEnum):
    """What the measurements say of a claim."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Tested:
    """A statistic of which a claim says where it lies.

    Attributes:
        what: the statistic, for people.
        low, high: where the claim says that it lies, both included.
        value: measured.
        ci_low, ci_high: its 95 % bootstrap interval over periods.
        p_claim: chance of such data if the claim did not hold, that is of resamples outside of the claimed range.
        p_other: chance of such data if it did: of resamples inside.
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
        """Whether this part `holds`, `fails`, or is `unclear`, going by its interval."""
        if self.low <= self.ci_low and self.ci_high <= self.high:
            return "holds"
        return "fails" if self.ci_high < self.low or self.ci_low > self.high else "unclear"


def in_range(what: str, value: float, samples: FloatArray, low: float, high: float) -> Tested:
    """Ask bootstrap samples of a statistic whether it lies in a range.

    Args:
        what: the statistic, for people.
        value: measured.
        samples: (resamples,)
        low: where the range begins; may be minus infinity.
        high: where it ends; may be infinity.
    """
    if np.isnan(samples).any() or math.isnan(value):  # such as no trials over no trials: nothing can be said
        return Tested(what, low, high, value, math.nan, math.nan, p_claim=1.0, p_other=1.0)
    inside = float(((samples >= low) & (samples <= high)).mean())
    least = 1 / (len(samples) + 1)  # no number of resamples makes sure
    ci_low, ci_high = percentile_interval(samples)
    chances = (max(1 - inside, least), max(inside, least))
    return Tested(what, low, high, value, float(ci_low), float(ci_high), *chances)


def exact(what: str, value: float, low: float, high: float) -> Tested:
    """A statistic that does not depend on chance."""
    holds = low <= value <= high
    return Tested(what, low, high, value, value, value, float(not holds), float(holds))


@dataclass(frozen=True)
class Finding:
    """What came of a claim.

    Attributes:
        verdict: on the claim.
        p: Holm's adjusted chance of a wrong verdict; NaN if nothing was measured.
        decisive: the part that the verdict hangs on; None if nothing was measured.
        parts: everything that the claim says.
    """

    verdict: Verdict
    p: float
    decisive: Tested | None
    parts: Sequence[Tested]


def judge(claims: Mapping[str, Sequence[Tested]]) -> dict[str, Finding]:
    """Verdicts on the claims of one study, by their names.

    A claim holds if all of its parts do, and does not if any one does not (Bonferroni over the parts). Its verdict
    needs a two-sided chance of error below 5 % after Holm's correction over the claims (Scand. J. Statist. 6, 1979).

    Args:
        claims: the parts of each claim; none where nothing was measured.
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
        # What a claim that holds hangs on is its weakest part; one that does not, the part that fails most surely.
        decisive = max(parts, key=lambda part: part.p_claim) if holds else min(parts, key=lambda part: part.p_other)
        verdict = decided if adjusted[name] < ERROR else Verdict.UNDECIDED
        findings[name] = Finding(verdict, adjusted[name], decisive, tuple(parts))
    return findings


def holm(chances: Mapping[str, float]) -> dict[str, float]:
    """Adjusted chances of error by Holm's step-down procedure."""
    ranked = sorted(chances, key=lambda name: chances[name])
    scaled = [min(1.0, (len(ranked) - rank) * chances[name]) for rank, name in enumerate(ranked)]
    return dict(zip(ranked, np.maximum.accumulate(scaled).tolist(), strict=True)) if ranked else {}


def _chances(parts: Sequence[Tested]) -> tuple[float, float]:
    return max(part.p_claim for part in parts), min(1.0, len(parts) * min(part.p_other for part in parts))
