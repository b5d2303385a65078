"""The ledger of claims: what a text says, and what the measurements say of it."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass as plain_dataclass
from dataclasses import field
from typing import Annotated, Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.claims import Finding, Tested, Verdict, judge
from rl_design_space.config.build import build, construct
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.markdown import table
from rl_design_space.report.points import Point, by_design
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import BLUE, LIGHT_GREEN, VERMILION, styled
from rl_design_space.tracking.selection import Where

PARTS = "_parts"
_HOW_TO_READ = (
    "A claim holds if all of its parts do, and fails if one of them does. The unit is the period; intervals are 95 % "
    "bootstrap intervals over periods, paired between points, because all points of one size meet the same layouts. "
    "Where a best value is chosen, it is chosen on one half of the periods and compared on the other. A verdict needs "
    "a chance of error below 5 % after Holm's correction over the claims of a study; otherwise it is undecided."
)
_PART_COLUMNS = ["claim", "what", "value", "ci_low", "ci_high", "claimed_low", "claimed_high", "state", "verdict"]
#: Stands for a parameter in which any two points differ.
_ANY = "fingerprint"
#: Colour and marker by the state of a part.
_LOOKS = {"holds": (BLUE, "o"), "fails": (VERMILION, "X"), "unclear": ("#6f6f6f", "D")}
#: Where the names of the claims stand, in widths of a part's axis.
_RIGHT = 1.55
#: Height of a part in inches, and the longest description of one in characters.
_HEIGHT, _LONGEST = 0.25, 78


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Claim:
    """One claim.

    Attributes:
        statement: what it says.
        study: whose table or figure shows it.
        parts: what must hold, each an option of `analysis.parts`; none if there is nothing to measure.
    """

    statement: Text
    study: Text
    parts: Annotated[tuple[Any, ...], Field(strict=False)]


@plain_dataclass(frozen=True)
class Judged:
    """A claim with its verdict.

    Attributes:
        name: of the claim.
        claim: what it says.
        finding: the verdict and what it rests on.
        missing: messages about points that are not recorded.
    """

    name: str
    claim: Claim
    finding: Finding
    missing: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ClaimsLedger(Report):
    """Verdicts on all claims.

    Attributes:
        common: values of parameters that all points have unless a part says otherwise.
        reading: values of parameters that a point has if it has such a parameter at all.
        claims: by name, each with `statement`, `study` (whose table or figure shows it) and `parts` (what must hold,
            each an option of `analysis.parts`).
    """

    shows: str = "Every part of every claim: its value with the 95 % interval, beside the range that the claim gives"
    common: Where
    reading: Where = field(default_factory=dict)
    claims: dict[str, dict[str, Any]]

    def judged(self, runs: Runs) -> list[Judged]:
        """Return the verdict on every claim, in their order; claims that lack a point are undecided.

        Raises:
            ConfigError: a claim has a value that is not allowed, or a part does not name its points.
        """
        data = _RecordedPoints(runs, self.common, self.reading)
        claims = {name: construct(Claim, node, f"claims.{name}") for name, node in self.claims.items()}
        tested: dict[str, list[Tested]] = {}
        missing: dict[str, list[str]] = {}
        for name, claim in claims.items():
            parts = [build(f"claims.{name}.parts.{i}", node) for i, node in enumerate(claim.parts)]
            try:
                tested[name] = [part.test(data) for part in parts]
            except LookupError as error:
                tested[name], missing[name] = [], [str(error)]
        findings: dict[str, Finding] = {}
        for study in dict.fromkeys(claim.study for claim in claims.values()):
            findings |= judge({name: tested[name] for name, claim in claims.items() if claim.study == study})
        return [Judged(name, claim, findings[name], missing.get(name, ())) for name, claim in claims.items()]

    def frames(self, runs: Runs) -> Frames:
        judged = self.judged(runs)
        return {MAIN: claims_frame(judged), PARTS: parts_frame(judged)}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[PARTS], self.title)

    def text(self, frames: Frames) -> list[str]:
        """Return the verdicts, and everything that each of them rests on."""
        claims, parts = frames[MAIN], frames[PARTS]
        counts = Counter(claims["verdict"])
        counted = ", ".join(f"{counts[verdict]} {verdict}" for verdict in Verdict)
        paragraphs = [
            f"**{len(claims)} claims: {counted}.**",
            table(_shown(claims, parts)),
            "## What each claim rests on",
        ]
        for each in claims.to_dict("records"):
            lines = [
                f"- {part['what']}: {_value(part)}, claimed {_claimed(part)}; {part['state']}"
                for part in parts[parts["claim"] == each["claim"]].to_dict("records")
            ]
            paragraphs.append(f"**{each['claim']}** – {each['statement']}: *{each['verdict']}*")
            paragraphs.append("\n".join(lines) or f"- {each['what'] or 'nothing to measure'}")
        return [
            *paragraphs,
            _HOW_TO_READ,
        ]


def claims_frame(judged: Sequence[Judged]) -> pd.DataFrame:
    """Return one row for each claim; its value is that of the part that the verdict depends on."""
    columns = ["claim", "statement", "verdict", "value", "ci_low", "ci_high", "study", "what", "p"]
    rows = []
    for each in judged:
        part = each.finding.decisive
        numbers = (part.value, part.ci_low, part.ci_high) if part else (float("nan"),) * 3
        what = part.what if part else "; ".join(each.missing)
        verdict = str(each.finding.verdict)
        rows.append((each.name, each.claim.statement, verdict, *numbers, each.claim.study, what, each.finding.p))
    return pd.DataFrame(rows, columns=columns)


def parts_frame(judged: Sequence[Judged]) -> pd.DataFrame:
    """Return one row for each part of a claim: its value with the interval, and the range that the claim gives."""
    rows = [
        (each.name, p.what, p.value, p.ci_low, p.ci_high, p.low, p.high, p.state, str(each.finding.verdict))
        for each in judged
        for p in each.finding.parts
    ]
    return pd.DataFrame(rows, columns=_PART_COLUMNS)


def _shown(claims: pd.DataFrame, parts: pd.DataFrame) -> pd.DataFrame:
    """Return the claims as texts, each with the part that its verdict depends on."""
    rows = []
    for each in claims.to_dict("records"):
        found = parts[(parts["claim"] == each["claim"]) & (parts["what"] == each["what"])].to_dict("records")
        numbers = ["", "", "", ""]
        if found:
            ends = f"{each['ci_low']:.3g} – {each['ci_high']:.3g}"
            numbers = [each["what"], f"{each['value']:.3g}", ends, _claimed(found[0])]
        plain = each["verdict"] == Verdict.REPRODUCED
        verdict = each["verdict"] if plain else f"**{each['verdict']}**"
        rows.append([each["claim"], each["statement"], verdict, *numbers, each["study"]])
    header = ["claim", "says", "verdict", "depends on", "value", "95 % interval", "claimed", "see"]
    return pd.DataFrame(rows, columns=header)


def _value(part: Mapping[Any, Any]) -> str:
    return f"{part['value']:.3g} ({part['ci_low']:.3g} – {part['ci_high']:.3g})"


def _claimed(part: Mapping[Any, Any]) -> str:
    """Return the range that a claim gives in words."""
    low, high = part["claimed_low"], part["claimed_high"]
    if math.isinf(low):
        return f"at most {high:g}"
    return f"at least {low:g}" if math.isinf(high) else f"{low:g} to {high:g}"


class _RecordedPoints:
    """Points of the parts of claims, see `analysis.parts.Data`."""

    def __init__(self, runs: Runs, common: Where, reading: Where) -> None:
        self._runs = runs.under(reading)
        self._common = common

    def one(self, where: Where) -> LearningCurves:
        return self._result(self._runs.seeds({**self._common, **where}))

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        values: dict[Any, list[Point]] = {}
        found = self._runs.where({**self._common, **where})
        if not found:
            wanted = " ".join(f"{name}={value}" for name, value in where.items())
            raise LookupError(f"no point of these studies has {wanted}")
        for seeds in by_design(found):
            value = seeds[0].planned.fingerprint if parameter == _ANY else seeds[0].parameters[parameter]
            values.setdefault(value, []).extend(seeds)
        return {value: self._result(seeds) for value, seeds in values.items()}

    def _result(self, seeds: Sequence[Point]) -> LearningCurves:
        result = self._runs.pooled(seeds)
        if result is None:
            missing = next((point for point in seeds if point.run is None), seeds[0])
            raise LookupError(f"missing: {missing.planned.command}")
        return result


@styled(font_size=8)
def _draw(parts: pd.DataFrame, title: str) -> Figure:
    """Draw one line for each part, on an axis of its own, scaled to show value, interval and claimed range.

    Args:
        parts: as `claims_ledger.parts_frame` returns them.
        title: of the picture.
    """
    figure, axis = plt.subplots(figsize=(12.5, 1.6 + _HEIGHT * max(len(parts), 4)), layout="constrained")
    for row, part in enumerate(parts.to_dict("records")):
        _draw_part(axis, row, part)
    names = [textwrap.shorten(what, _LONGEST, placeholder=" …") for what in parts["what"]]
    axis.set_yticks(range(len(parts)), names)
    for claim, rows in parts.reset_index().groupby("claim", sort=False)["index"]:
        verdict = parts.loc[rows.iloc[0], "verdict"]
        axis.text(_RIGHT, rows.mean(), f"{claim}\n{verdict}", va="center", fontsize=8, fontweight="bold")
        axis.axhline(rows.iloc[-1] + 0.5, color="0.85", linewidth=0.8, clip_on=False)
    axis.set_ylim(max(len(parts), 1) - 0.4, -0.8)
    axis.set_xlim(-0.03, _RIGHT + 0.32)
    axis.set_xticks([])
    axis.tick_params(length=0)
    axis.spines[:].set_visible(False)
    marks = [Line2D([], [], color=colour, marker=marker, label=state) for state, (colour, marker) in _LOOKS.items()]
    claimed = Rectangle((0, 0), 1, 1, color=LIGHT_GREEN, label="range that the claim gives")
    figure.legend(handles=[*marks, claimed], loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def _draw_part(axis: Axes, row: int, part: Mapping[Any, Any]) -> None:
    if np.isnan(part["value"]):
        axis.text(0.5, row, "not defined: 0 / 0", ha="center", va="center", fontsize=7)
        return
    ends = [part[name] for name in ("ci_low", "ci_high", "claimed_low", "claimed_high") if np.isfinite(part[name])]
    low, high = min(ends), max(ends)
    margin = 0.35 * (high - low) or 0.1 * abs(high) or 1.0
    low, high = low - margin, high + margin

    def at(value: float) -> float:
        return float(np.clip((value - low) / (high - low), 0, 1))

    begin, end = at(part["claimed_low"]), at(part["claimed_high"])
    axis.barh(row, end - begin, left=begin, height=0.7, color=LIGHT_GREEN, zorder=1)
    colour, marker = _LOOKS[part["state"]]
    axis.plot([at(part["ci_low"]), at(part["ci_high"])], [row, row], color=colour, linewidth=2, zorder=2)
    axis.plot(at(part["value"]), row, color=colour, marker=marker, markersize=5, zorder=3)
    bounds = [f"{part[name]:.3g}" for name in ("claimed_low", "claimed_high") if np.isfinite(part[name])]
    sign = "≥ " if np.isinf(part["claimed_high"]) else "≤ " if np.isinf(part["claimed_low"]) else ""
    text = f"{part['value']:.3g} ({part['ci_low']:.3g} – {part['ci_high']:.3g}); claimed {sign}{' – '.join(bounds)}"
    axis.text(1.02, row, text, va="center", fontsize=7)
