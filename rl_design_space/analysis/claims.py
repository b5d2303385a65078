"""Verdicts on claims: decisions on the tested parts of several claims."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from rl_design_space.analysis.tested import Tested, all_chances, exact, in_range

__all__ = ["ERROR", "Finding", "Tested", "Verdict", "exact", "holm", "in_range", "judge"]

#: Probability of any wrong verdict among the claims that are judged together.
ERROR = 0.05


class Verdict(StrEnum):
    """Verdict of the measurements on a claim."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    UNDECIDED = "undecided"


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
    """Judge claims together, such as those of one study; return findings by name.

    A claim holds if all of its parts hold, and fails if any part fails (Bonferroni over the parts). A verdict requires
    a two-sided error probability below 5 % after Holm's correction over the claims (Scand. J. Statist. 6, 1979).

    Args:
        claims: the tested parts of each claim; none if nothing was measured.
    """
    chances = {name: all_chances(parts) for name, parts in claims.items() if parts}
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
