"""What the page says of each claim first: a sentence, a mark, the verdicts, a number and a small picture."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import pandas as pd

from rl_design_space.analysis.multiverse.marks import Mark
from rl_design_space.report.multiverse_figure import MOST
from rl_design_space.report.multiverse_text import sentence
from rl_design_space.report.style import BLUE, GREY, VERMILION, interval, number

#: Sign and class of each mark; signs differ in more than their colour.
_SIGNS = {Mark.HOLDS: ("●", "good"), Mark.UNDER: ("◐", "part"), Mark.NOWHERE: ("○", "bad"), Mark.OPEN: ("?", "open")}
_CLASSES = {"reproduced": "good", "not reproduced": "bad", "undecided": "open"}
#: Size of a small picture.
_WIDTH, _HEIGHT = 244, 60


@dataclass(frozen=True)
class PageClaim:
    """A claim as the page shows it.

    Attributes:
        name: of the claim.
        study: whose report shows it.
        statement: what it says.
        mark, sign, kind: its outcome over all specifications, as text, sign and class; empty without a multiverse.
        verdicts: heading, verdict and class of each verdict, the registered one first.
        measured: the number that the registered verdict depends on, with its interval and what it is.
        picture: its specification curve as SVG; empty without a multiverse.
    """

    name: str
    study: str
    statement: str
    mark: str
    sign: str
    kind: str
    verdicts: Sequence[tuple[str, str, str]]
    measured: str
    picture: str


def page_claims(ledger: Path, multiverse: Path | None) -> list[PageClaim]:
    """Return the claims of a ledger.

    Args:
        ledger: its CSV file.
        multiverse: path of the files of a multiverse without what follows its name; None if there is none.
    """
    marks: dict[str, dict[Any, Any]] = {}
    curves: dict[str, pd.DataFrame] = {}
    if multiverse:
        read = (pd.read_csv(multiverse.with_name(f"{multiverse.name}{name}.csv")) for name in ("_claims", "_curve"))
        claims, curve = read
        marks = {row["claim"]: row for row in claims.fillna({"choices": "", "hangs_on": ""}).to_dict("records")}
        curves = {str(name): rows for name, rows in curve.groupby("claim")}
    numbers = dict.fromkeys(("value", "ci_low", "ci_high"), "")
    rows = pd.read_csv(ledger, keep_default_na=False, na_values=numbers).to_dict("records")
    return [_claim(row, marks.get(row["claim"]), curves.get(row["claim"])) for row in rows]


def _claim(row: Mapping[Any, Any], mark: Mapping[Any, Any] | None, curve: pd.DataFrame | None) -> PageClaim:
    verdicts = [("as registered", str(row["verdict"]), _CLASSES[row["verdict"]])]
    if later := row.get("later_verdict"):
        verdicts.append(("later", str(later), _CLASSES[later]))
    measured = str(row["what"])
    if pd.notna(row["value"]):
        measured = f"{row['what']}: {_number(row['value'], row['ci_low'], row['ci_high'])}"
    sign, kind = _SIGNS[Mark(mark["mark"])] if mark else ("", "")
    return PageClaim(
        row["claim"], row["study"], row["statement"], sentence(mark) if mark else "", sign, kind, verdicts, measured,
        _picture(mark, curve) if mark and curve is not None else "",
    )  # fmt: skip


def _number(value: float, low: float, high: float) -> str:
    """Return a value with its interval; as a bound where it is the end of an interval without another end."""
    if math.isinf(high) and value == low:
        return f"≥ {number(value)}"
    return f"{number(value)} (≥ {number(low)})" if math.isinf(high) else f"{number(value)} ({interval(low, high)})"


def _picture(mark: Mapping[Any, Any], curve: pd.DataFrame) -> str:
    """Return a specification curve as SVG: a bar for each place in the order, up where the claim holds."""
    rows = curve.to_dict("records")
    wide, middle = _WIDTH / len(rows), _HEIGHT / 2
    bars = []
    for place, row in enumerate(rows):
        height = max(abs(row["log"]), 0.04) * (middle - 2)
        top = middle - height if row["log"] >= 0 else middle
        colour = {"holds": BLUE, "fails": VERMILION}.get(row["state"], GREY)
        bars.append(
            f'<rect x="{place * wide:.1f}" y="{top:.1f}" width="{wide:.2f}" height="{height:.1f}" fill="{colour}"/>'
        )
    about = (
        f"Specification curve of {mark['claim']}: it holds under {mark['share']:.0%} of {mark['specifications']:,} "
        f"specifications; bars reach up to {MOST:g} times the limit"
    )
    return (
        f'<svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{escape(about)}">{"".join(bars)}'
        f'<path d="M0 {middle}H{_WIDTH}" stroke="#444" stroke-width="1"/></svg>'
    )
