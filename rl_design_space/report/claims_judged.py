"""Verdicts on claims, registered and later, and the frames that hold them."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from rl_design_space.analysis.claims import Finding, Tested, judge
from rl_design_space.analysis.parts import Part
from rl_design_space.report.claims import BuiltClaim, Claim
from rl_design_space.report.claims_points import RecordedPoints

_NAN = float("nan")
_CLAIM_COLUMNS = ["claim", "statement", "verdict", "value", "ci_low", "ci_high", "study", "what", "p"]
_LATER_COLUMNS = [f"later_{name}" for name in ("verdict", "value", "ci_low", "ci_high", "what", "p", "periods")]
_PART_COLUMNS = [
    "claim", "what", "value", "ci_low", "ci_high", "claimed_low", "claimed_high", "state", "verdict", "sign",
    "others_passing", "others", "near", "others_near", "remarks",
]  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """A claim with its verdict.

    Attributes:
        name: of the claim.
        claim: what it says.
        finding: the verdict and what it rests on.
        missing: messages about points that are not recorded.
        later: the verdict that came later; None if the ledger has none.
        later_missing: messages about points that are not recorded, for the later verdict.
        later_periods: numbers of periods that the later verdict rests on.
    """

    name: str
    claim: Claim
    finding: Finding
    missing: Sequence[str] = ()
    later: Finding | None = None
    later_missing: Sequence[str] = ()
    later_periods: Sequence[int] = ()


class TestedParts:
    """Tested parts of claims, or why they could not be tested.

    Args:
        parts: of each claim.
        data: the points.
        larger: larger samples of the points; None if there are none.
        claims: those that are tested on the larger samples, if all of their points have one.
    """

    def __init__(
        self,
        parts: Mapping[str, Sequence[Part]],
        data: RecordedPoints,
        larger: RecordedPoints | None = None,
        claims: Container[str] = (),
    ) -> None:
        self.tested: dict[str, list[Tested]] = {}
        self.missing: dict[str, list[str]] = {}
        #: Numbers of periods that each claim was tested on.
        self.periods: dict[str, Sequence[int]] = {}
        for name, each in parts.items():
            if larger and name in claims and self._test(name, each, larger, one_by_one=True):
                continue
            self._test(name, each, data)

    def _test(self, name: str, parts: Sequence[Part], data: RecordedPoints, one_by_one: bool = False) -> bool:
        """Test the parts of a claim; return whether all of its points are there."""
        data.periods.clear()
        self.tested[name], self.missing[name] = [], []
        try:
            for part in parts:
                self.tested[name].append(part.test(data))
                if one_by_one:
                    data.forget()
        except LookupError as error:
            self.tested[name], self.missing[name] = [], [str(error)]
        self.periods[name] = sorted(data.periods) if self.tested[name] else []
        return not self.missing[name]


def registered_findings(claims: Mapping[str, BuiltClaim], tests: TestedParts) -> dict[str, Finding]:
    """Return the verdicts on registered parts: the claims of each study are judged together."""
    findings: dict[str, Finding] = {}
    for study in dict.fromkeys(each.claim.study for each in claims.values()):
        findings |= judge({name: tests.tested[name] for name, each in claims.items() if each.claim.study == study})
    return findings


def later_findings(tests: TestedParts) -> dict[str, Finding]:
    """Return the verdicts on later parts: all claims are judged together, as the headline counts them."""
    return judge(tests.tested)


def claims_frame(judged: Sequence[Judged]) -> pd.DataFrame:
    """Return one row for each claim; its value is that of the part that the verdict depends on."""
    rows = []
    for each in judged:
        verdict, *numbers, what, p = _found(each.finding, each.missing)
        rows.append((each.name, each.claim.statement, verdict, *numbers, each.claim.study, what, p))
    frame = pd.DataFrame(rows, columns=_CLAIM_COLUMNS)
    if any(each.later for each in judged):
        later = [
            (*_found(each.later, each.later_missing or _awaited(each)), " to ".join(map(str, each.later_periods)))
            for each in judged
            if each.later
        ]
        return pd.concat([frame, pd.DataFrame(later, columns=_LATER_COLUMNS)], axis=1)
    return frame


def _found(finding: Finding, missing: Sequence[str]) -> tuple[str, float, float, float, str, float]:
    if finding.decisive is None:
        return str(finding.verdict), _NAN, _NAN, _NAN, "; ".join(missing), finding.p
    what, part = finding.decisive.deciding()
    return str(finding.verdict), part.value, part.ci_low, part.ci_high, what, finding.p


def _awaited(each: Judged) -> Sequence[str]:
    return [f"awaits {each.claim.awaits}"] if each.claim.awaits else []


def parts_frame(judged: Sequence[Judged], later: bool = False) -> pd.DataFrame:
    """Return one row for each part of a claim: its value with the interval, and the range that the claim gives.

    Args:
        judged: the claims.
        later: whether the parts are those of the later verdicts.
    """
    rows = []
    for each in judged:
        finding = each.later if later else each.finding
        if finding is None:
            continue
        for part in finding.parts:
            for what, p in part.leaves():
                numbers = (p.value, p.ci_low, p.ci_high, p.low, p.high)
                more = (p.sign, *(p.severity or (_NAN,) * 4), "; ".join(p.remarks))
                rows.append((each.name, what, *numbers, p.state, str(finding.verdict), *more))
    return pd.DataFrame(rows, columns=_PART_COLUMNS)
