"""The text of a multiverse: marks, what they hang on, and the joint specification."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from rl_design_space._markdown import code
from rl_design_space.analysis.multiverse.marks import CLEAR, MOSTLY, Mark
from rl_design_space.report.markdown import table
from rl_design_space.report.multiverse_numbers import RESAMPLES

#: Components of the variance that are listed for each claim.
_LISTED = 3


def paragraphs(claims: pd.DataFrame, factors: pd.DataFrame, joint: pd.DataFrame, triples: Sequence[str]) -> list[str]:
    """Return the paragraphs of the text; see `Multiverse.frames` for the frames, and `triples`."""
    (first,) = counted(claims)
    missing = claims[claims["missing"].str.startswith("missing")]
    return [
        f"**{first}.**",
        table(marks(claims)),
        *(f"{each['claim']}: {each['missing']}" for each in missing.to_dict("records")),
        "## What each verdict hangs on",
        table(_hanging(claims, factors)),
        "## All claims at once",
        *_joint(joint),
        "## Triples of readings",
        *triples,
        "## How to read this",
        *_HOW_TO_READ,
    ]


def counted(claims: pd.DataFrame) -> list[str]:
    """Return how many marks there are of each kind, as a sentence without an end."""
    counts = Counter(claims["mark"])
    parts = ", ".join(f"{counts[mark]} {_plural(mark, counts[mark])}" for mark in Mark)
    return [f"{len(claims)} claims under {claims['specifications'].sum():,} specifications: {parts}"]


def marks(claims: pd.DataFrame) -> pd.DataFrame:
    """Return the mark of each claim with its shares, as texts."""
    return pd.DataFrame([_row(each) for each in claims.to_dict("records")], columns=_HEADER)


def triples(near: pd.DataFrame, factor: float, specifications: int) -> list[str]:
    """Return the paragraphs about pairs of readings that came near, and about triples.

    Args:
        near: the pairs, see `multiverse_near.near_frame`.
        factor: that says which pairs came near.
        specifications: number of those that have three departures.
    """
    pairs = near["reading"].nunique()
    hold = near[near["hold"] > 0]
    found = [
        "A pair of readings came near if, by one measure and statistic and the registered limits, a claim holds under "
        "no reading, alone or in pairs; if under the pair the value that decides is beyond its limit by a factor of "
        f"{factor:g} at most; and if it is farther beyond as decided and under each of the two alone. Each other "
        "reading is then added to the pair. Such triples are selected, so neither shares nor the joint specifications "
        f"count them. {pairs} pairs came near, in {len(near)} cases; triples make {specifications:,} more "
        f"specifications, and the claim holds under one of them in {len(hold)} of the cases.",
    ]
    if not (near["triples"] > 0).all():
        without = near[near["triples"] == 0]["reading"].unique()
        found.append(f"No triples were run around {'; '.join(without)}: name them in `variations.around` of the study.")
    if len(near):
        shown = near.assign(
            factor=near["factor"].map("{:.3f}".format), nearest_factor=near["nearest_factor"].map("{:.3f}".format)
        )
        header = ["claim", "measure", "statistic", "pair", "factor", "triples", "hold", "nearest triple", "its factor"]
        found.append(table(shown.set_axis(header, axis=1)))
    return found


_HEADER = ["claim", "says", "mark", "holds under", "clear", "specifications", "a placebo does as well"]
_HOW_TO_READ = [
    "A specification is a reading of the paper, a measure of what a claim speaks of, a statistic over periods, and a "
    "set of limits. A claim holds under it if the measured values lie within the limits; the interval (95 %, "
    f"{RESAMPLES:,} resamples of whole periods) says how sure that is. A specification is clear if at least "
    f"{CLEAR:.1%} of the resamples come out in the same way. Readings that leave all points of a claim as they are "
    "count once.",
    f"*Holds*: under at least {MOSTLY:.0%} of its specifications. *Holds under …*: of those with the named choices at "
    f"least {MOSTLY:.0%} hold; where no two choices are enough, the best one is named with its share. *Does not hold "
    f"under anything tried*: under at most {1 - MOSTLY:.0%}, clearly under none, and clearly not under most. *Cannot "
    "be told*: the rest.",
    "A placebo is the claim with another value of the grid in place of each one that it calls the best. Shares of the "
    "variance are of the verdict, 0 or 1, with each alternative reading taken independently and one of them on "
    "average; *alone* is the first-order share, *with others* the total one.",
    "Specification curves show how far the value that decides lies within its limit, as a factor: above 1 the claim "
    "holds. Dark points are clear.",
]  # fmt: skip


def _plural(mark: Mark, number: int) -> str:
    if number == 1:
        return str(mark) + (" some choices" if mark is Mark.UNDER else "")
    words = {
        Mark.HOLDS: "hold",
        Mark.UNDER: "hold under some choices",
        Mark.NOWHERE: "do not hold under anything tried",
    }
    return words.get(mark, str(mark))


def sentence(claim: Mapping[Any, Any]) -> str:
    """Return the mark of a claim with the choices under which it holds."""
    if claim["mark"] != Mark.UNDER:
        return str(claim["mark"])
    choices = claim["choices"].replace("; ", " and ")
    if claim["within"] >= MOSTLY:
        return f"holds under {choices}"
    return f"holds under {claim['share']:.0%} of all, most often under {choices} ({claim['within']:.0%})"


def _row(claim: Mapping[Any, Any]) -> list[str]:
    mark = sentence(claim)
    told = pd.notna(claim["share"])
    shares = [f"{claim['share']:.0%}", f"{claim['clear']:.0%}"] if told else ["–", "–"]
    placebo = f"{claim['placebo']:.2%}" if pd.notna(claim["placebo"]) else "–"
    return [claim["claim"], claim["statement"], f"**{mark}**", *shares, f"{claim['specifications']:,}", placebo]


def _hanging(claims: pd.DataFrame, factors: pd.DataFrame) -> pd.DataFrame:
    rows = []
    for claim in claims.to_dict("records"):
        own = factors[factors["claim"] == claim["claim"]].nlargest(_LISTED, "share").to_dict("records")
        listed = ", ".join(f"{code(part['factors'])} {part['share']:.0%}" for part in own)
        shares = [f"{claim['first']:.0%}", f"{claim['total']:.0%}"] if own else ["–", "–"]
        rows.append([claim["claim"], claim["hangs_on"] or "nothing tried", *shares, listed])
    return pd.DataFrame(
        rows, columns=["claim", "hangs most on", "alone", "with others", "largest parts of the variance"]
    )


def _joint(joint: pd.DataFrame) -> list[str]:
    if joint.empty:
        return ["No claim could be measured."]
    header = [
        "chosen within", "reading", "statistic", "limits", "measures", "claims", "departures", "gains", "loses",
        "placebos do as well",
    ]  # fmt: skip
    rows = []
    for each in joint.to_dict("records"):
        rows.append([each[name] for name in ("within", "reading", "statistic", "threshold", "measures")])
        rows[-1] += [
            f"{each['hold']} of {each['of']}",
            str(each["departures"]),
            each["gains"] or "–",
            each["loses"] or "–",
        ]
        rows[-1].append(f"{each['placebo']:.2%}" if each["placebos"] else "–")
    best = joint.iloc[-1]
    said = (
        f"Most claims hold at once, {best['hold']} of {best['of']}, with these choices: reading {best['reading']}, "
        f"{best['statistic']}, limits {best['threshold']}, {best['measures']}."
    )
    placebos = (
        f"Of {best['placebos']:,} placebos, whose best values are drawn from the rest of the grids, "
        f"{best['placebo']:.2%} reach as many when the same choices are searched for each of them "
        f"({best['placebo_mean']:.1f} claims on average), and {best['placebo_same']:.2%} with the choices above."
    )
    return [table(pd.DataFrame(rows, columns=header)), f"{said} {placebos}" if best["placebos"] else said]
