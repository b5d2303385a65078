"""The text of the ledger of claims, from its frames alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

import pandas as pd

from rl_design_space.analysis.claims import Verdict
from rl_design_space.analysis.placebo import placebo
from rl_design_space.report.markdown import table

#: Column of the verdicts that came later.
_LATER = "later_verdict"
_HOW_TO_READ = (
    "A claim holds if all of its parts do, and fails if one of them does. The unit is the period; intervals are 95 % "
    "bootstrap intervals over periods, paired between points, because all points of one size meet the same layouts. "
    "Where a best value is chosen, it is chosen on one half of the periods and compared on the other. A verdict needs "
    "a chance of error below 5 % after Holm's correction over the claims of a study; otherwise it is undecided."
)
_HOW_LATER = (
    "Later verdicts came when the registered ones were known. An audit had found where the registered criteria say "
    "something else than the paper's words, or draw a wrong conclusion from the numbers; each claim's later criteria "
    "mend that, were written down before they were applied, and stand beside the registered ones instead of replacing "
    "them. A best value is compared with every other value of its grid on all periods, and a later verdict needs a "
    "chance of error below 5 % after Holm's correction over all claims. Claims that 500 periods left undecided have "
    "more of them, if these are recorded; which ones and how many was fixed before they were run."
)


def paragraphs(claims: pd.DataFrame, parts: pd.DataFrame, later_parts: pd.DataFrame | None) -> list[str]:
    """Return the verdicts, and everything that each of them rests on.

    Args:
        claims: as `claims_judged.claims_frame` returns them.
        parts: as `claims_judged.parts_frame` returns them.
        later_parts: those of the later verdicts; None if there are none.
    """
    first, *later = counted(claims)
    found = [f"**{first}.**", *(f"{line}. {_HOW_LATER}" for line in later)]
    found.append(table(_shown(claims, parts)))
    if later_parts is not None:
        found += ["## Verdicts that came later", table(_shown(_as_later(claims), later_parts))]
        found += _placebo_lines(parts, later_parts)
    found.append("## What each claim rests on")
    for each in claims.to_dict("records"):
        found += _rests_on(each, parts, later_parts)
    return [*found, _HOW_TO_READ]


def counted(claims: pd.DataFrame) -> list[str]:
    """Return how many verdicts there are of each kind, as sentences without an end: registered, then later ones."""
    later = [f"By criteria that came later: {_counts(claims[_LATER])}"] if _LATER in claims else []
    return [f"{len(claims)} claims: {_counts(claims['verdict'])}", *later]


def verdicts(claims: pd.DataFrame) -> pd.DataFrame:
    """Return the verdicts on each claim, and what it says."""
    later = {"later": claims[_LATER]} if _LATER in claims else {}
    return pd.DataFrame({"claim": claims["claim"], "verdict": claims["verdict"], **later, "says": claims["statement"]})


def _counts(verdicts: pd.Series[str]) -> str:
    counts = Counter(verdicts)
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)


def _as_later(claims: pd.DataFrame) -> pd.DataFrame:
    """Return the claims with their later verdicts in the place of the registered ones."""
    later = {name: name.removeprefix("later_") for name in claims.columns if name.startswith("later_")}
    return claims.drop(columns=list(later.values()), errors="ignore").rename(columns=later)


def _placebo_lines(parts: pd.DataFrame, later_parts: pd.DataFrame) -> list[str]:
    """Return how many best values of the paper hold by either criteria, and how likely others would do as well."""
    lines = []
    for criteria, frame in (("registered", parts), ("later", later_parts)):
        best = frame[frame["others"] > 0]
        tests = placebo(zip(best["state"] == "holds", best["others_passing"], best["others"], strict=True))
        near = placebo(zip(best["near"], best["others_near"], best["others"], strict=True))
        if tests and near:
            lines.append(
                f"- {criteria} criteria: {tests.holding} of {tests.best} hold (placebo {tests.chance:.2g}); without "
                f"regard to intervals {near.holding} are within their range (placebo {near.chance:.2g})"
            )
    explained = (
        "Of the best values that the paper names, so many hold. The placebo is the probability that at least as many "
        "would if each was drawn at random from the other values of its grid:"
    )
    return [explained, "\n".join(lines)] if lines else []


def _rests_on(claim: Mapping[Any, Any], parts: pd.DataFrame, later_parts: pd.DataFrame | None) -> list[str]:
    heading = f"**{claim['claim']}** – {claim['statement']}: *{claim['verdict']}*"
    found = [heading, _lines(claim["claim"], parts) or f"- {claim['what'] or 'nothing to measure'}"]
    if later_parts is not None:
        nothing = f"- {claim['later_what'] or 'nothing to measure'}"
        found += [f"Later: *{claim['later_verdict']}*", _lines(claim["claim"], later_parts) or nothing]
    return found


def _lines(claim: str, parts: pd.DataFrame) -> str:
    return "\n".join(
        f"- {part['what']}: {_value(part)}, claimed {_claimed(part)}; {part['state']}{_remarks(part)}"
        for part in parts[parts["claim"] == claim].to_dict("records")
    )


def _remarks(part: Mapping[Any, Any]) -> str:
    """Return what a reader should know of a part: how many other values would have passed, edges of grids."""
    remarks = [part["remarks"]] if part["remarks"] else []
    if part["others"] > 0:
        remarks.insert(0, f"{part['others_passing']:.0f} of the {part['others']:.0f} other values would pass")
    return f" ({'; '.join(remarks)})" if remarks else ""


def _shown(claims: pd.DataFrame, parts: pd.DataFrame) -> pd.DataFrame:
    """Return the claims as texts, each with the part that its verdict depends on."""
    rows = []
    of_later = "periods" in claims
    for each in claims.to_dict("records"):
        found = parts[(parts["claim"] == each["claim"]) & (parts["what"] == each["what"])].to_dict("records")
        numbers = ["", "", "", ""]
        if found:
            numbers = [each["what"], _number(found[0]), _interval(found[0]), _claimed(found[0])]
        plain = each["verdict"] == Verdict.REPRODUCED
        verdict = each["verdict"] if plain else f"**{each['verdict']}**"
        periods = [each["periods"]] if of_later else []
        rows.append([each["claim"], each["statement"], verdict, *numbers, *periods, each["study"]])
    more = ["periods"] if of_later else []
    header = ["claim", "says", "verdict", "depends on", "value", "95 % interval", "claimed", *more, "see"]
    return pd.DataFrame(rows, columns=header)


def _value(part: Mapping[Any, Any]) -> str:
    return f"{_number(part)} ({_interval(part)})"


def _number(part: Mapping[Any, Any]) -> str:
    return f"{part['sign']} {part['value']:.3g}".strip()


def _interval(part: Mapping[Any, Any]) -> str:
    low, high = part["ci_low"], part["ci_high"]
    return f"≥ {low:.3g}" if math.isinf(high) else f"≤ {high:.3g}" if math.isinf(low) else f"{low:.3g} – {high:.3g}"


def _claimed(part: Mapping[Any, Any]) -> str:
    """Return the range that a claim gives in words."""
    low, high = part["claimed_low"], part["claimed_high"]
    if math.isinf(low):
        return f"at most {high:g}"
    return f"at least {low:g}" if math.isinf(high) else f"{low:g} to {high:g}"
