"""The multiverse: every claim under every sensible reading, measure, statistic and set of limits."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.multiverse.joint import as_good
from rl_design_space.analysis.multiverse.marks import Mark, Marked, marked, with_triples
from rl_design_space.analysis.multiverse.variance import Component, decompose, first_order, total
from rl_design_space.config.build import construct, plain
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.report import multiverse_figure, multiverse_text
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.multiverse_claims import MultiverseClaim, Role, worded
from rl_design_space.report.multiverse_joint import joint_frame
from rl_design_space.report.multiverse_near import near_frame
from rl_design_space.report.multiverse_numbers import Numbers
from rl_design_space.report.multiverse_outcomes import ClaimOutcomes, Row, asked, choices, outcomes
from rl_design_space.report.multiverse_points import AND, ReadPoints, Space, alternatives, readings_of
from rl_design_space.report.runs import Runs
from rl_design_space.report.written import MainNumbers
from rl_design_space.tracking.selection import Where

CLAIMS, FACTORS, JOINT, CURVE, NEAR = "_claims", "_factors", "_joint", "_curve", "_near"
_COLUMNS = ["claim", "reading", "measure", "statistic", "threshold", "holds", "value", "low", "high"]
#: Readings of so many departures are those that every claim is judged under; of so many, those that claims may have.
_EVERY, _MOST = 2, 3
_Words = Annotated[dict[str, float], Field(strict=False)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Multiverse(Report):
    """All claims under all of their specifications: reading × measure × statistic × limits.

    Attributes:
        ledger: the study whose report says what the claims are, a `ClaimsLedger`.
        common: values of parameters that all points have unless a part says otherwise.
        decided: values of the parameters that readings change, under the reading that was decided for.
        readings: what each alternative reading changes, by name; those of the study's variations.
        apart: pairs of parameters; readings of the first count separately for each value of the second.
        roles: what a word of the claims may be measured by, with `measures` and `statistics`.
        thresholds: sets of limits by name, each by word; the first is the registered one.
        near: factor that says which pairs of readings came near to making a claim hold: by one measure and statistic
            and the registered limits, the claim holds under no reading, alone or in pairs; under the pair the value
            that decides is beyond its limit by this factor at most; and it is farther beyond as decided and under each
            of the two alone. Their triples, with each other reading added, belong into the study's variations
            (`around`). Triples are thus selected, so shares and joint specifications leave them out.
        claims: by name as in the ledger, each with `role` and `parts`: options of `analysis.parts` with roles as
            measures and words as limits.
    """

    builds_options: ClassVar[bool] = True  # the parts: once for each measure, statistic and set of limits

    shows: str = (
        "A heatmap: for each claim and each reading, the share of the measures, statistics and limits under which the "
        "claim holds; then the same for each measure, statistic and set of limits"
    )
    ledger: str
    common: Where
    decided: Where
    readings: dict[str, Where]
    apart: dict[str, str] = Field(default_factory=dict)
    roles: dict[str, Any]
    thresholds: Annotated[dict[str, _Words], Field(min_length=1)]
    near: Annotated[float, Field(ge=1)] = 1.05
    claims: dict[str, Any]

    def frames(self, runs: Runs) -> Frames:
        """Return one row for each specification, for each claim, for each factor of a claim, and joint ones.

        Returns:
            Specifications: claim, reading, measure, statistic, threshold, holds (empty if it cannot be told), value,
            low, high (of the part that decides). Not written: what, margin, certainty.
            `_claims`: claim, statement, mark, share, clear, choices, within, specifications, placebo, hangs_on, first,
            total, missing. `_factors`: claim, factors, share. `_joint`: see `multiverse_joint.joint_frame`. `_curve`:
            see `multiverse_figure.curve`. `_near`: see `multiverse_near.near_frame`.
        """
        space, found = self.evaluated(runs)
        statements = self._statements()
        rows = [_described(each, space) for each in found.values()]
        claims, factors = [], []
        for name, statement in statements.items():
            components: list[Component] = []
            if name not in found:
                mark, number, placebo, missing = Marked(Mark.OPEN, np.nan, np.nan), 0, np.nan, "nothing to measure"
            else:
                each = found[name]
                mark, components, missing = _marked(each, space), _components(each, space), each.missing
                number, placebo = len(_of_every(each, space)), as_good(each.outcomes)
            hangs = _largest(components)
            shares = (mark.share, mark.clear, "; ".join(mark.choices), mark.within)
            claims.append((name, statement, str(mark.mark), *shares, number, placebo, *hangs, missing))
            factors += [(name, " × ".join(sorted(part.factors)), part.share) for part in components]
        specifications = pd.concat(rows, ignore_index=True)
        return {
            MAIN: specifications,
            CLAIMS: pd.DataFrame(claims, columns=_CLAIM_COLUMNS),
            FACTORS: pd.DataFrame(factors, columns=["claim", "factors", "share"]),
            JOINT: joint_frame(found, space, self._roles()),
            CURVE: multiverse_figure.curve(unselected(specifications)),
            NEAR: near_frame(found, space, self.near),
        }

    def csv(self, frames: Frames) -> Frames:
        return {**frames, MAIN: frames[MAIN][_COLUMNS]}

    def draw(self, frames: Frames) -> Figure:
        return multiverse_figure.heatmap(unselected(frames[MAIN]), frames[CLAIMS], self.title)

    def main_numbers(self, frames: Frames) -> MainNumbers:
        """Return how many marks there are of each kind, and a row for each claim."""
        claims = frames[CLAIMS]
        return MainNumbers.of(
            self._in_words(self.heading), multiverse_text.counted(claims), multiverse_text.marks(claims)
        )

    def text(self, frames: Frames) -> list[str]:
        """Return the marks, what each hangs on, the joint specification, and how the words are to be read."""
        specifications = frames[MAIN]
        more = len(specifications) - len(unselected(specifications))
        return multiverse_text.paragraphs(
            frames[CLAIMS], frames[FACTORS], frames[JOINT], multiverse_text.triples(frames[NEAR], self.near, more)
        )

    def more_pictures(self, frames: Frames) -> Iterator[tuple[str, str, Figure]]:
        """Yield the specification curve of each claim that has several specifications."""
        statements = frames[CLAIMS].set_index("claim")["statement"]
        for claim, rows in unselected(frames[MAIN]).groupby("claim", sort=False):
            if len(told := rows.dropna(subset="margin")) > 1:
                about = f"Specification curve of {claim}, {statements[claim]}: all in order, and the choices of each"
                yield f"-{claim}", about, multiverse_figure.specification_curve(told, f"{claim}: {statements[claim]}")

    def evaluated(self, runs: Runs) -> tuple[Space, dict[str, ClaimOutcomes]]:
        """Return what the specifications are made of, and the outcomes of each claim by name.

        Raises:
            ConfigError: a claim has a value that is not allowed, or a part does not name its points.
        """
        there = alternatives(self.readings, self.apart, runs.points)
        every = len(readings_of(there, _EVERY))
        space = Space(there, readings_of(there, _MOST), every, list(self.thresholds), self.decided)
        points = ReadPoints(runs.points, self.decided, self.common, there)
        roles = self._roles()
        wordings = {
            name: worded(name, construct(MultiverseClaim, node, f"claims.{name}"), roles, self.thresholds)
            for name, node in self.claims.items()
        }
        wanted: dict[Any, set[str]] = {}
        for wording in wordings.values():
            noted: dict[int, set[str]] = {}
            for base, measure in asked(wording, points):
                noted.setdefault(base, set()).add(measure)
            for number, reading in enumerate(space.readings):
                if number < every or points.has(noted, reading):
                    for base, measures in noted.items():
                        wanted.setdefault(points.read(base, reading), set()).update(measures)
        numbers = Numbers(runs)
        numbers.compute(wanted)
        return space, {name: outcomes(wording, points, numbers, space) for name, wording in wordings.items()}

    def _roles(self) -> dict[str, Role]:
        return {name: construct(Role, node, f"roles.{name}") for name, node in self.roles.items()}

    def _statements(self) -> dict[str, str]:
        """Return what the claims say.

        Raises:
            ConfigError: the ledger's study has another report, or does not have one of the claims.
        """
        with shipped_config():
            node = plain(Composer().config([f"study={self.ledger}"]), "study").get("report")
        ledger = node.get("claims") if isinstance(node, Mapping) else None
        if not isinstance(ledger, Mapping):
            raise ConfigError.at("report.ledger", self.ledger, "should be a study whose report is a ClaimsLedger")
        for name in self.claims:
            if name not in ledger:
                raise ConfigError.unknown("claim", name, ledger)
        return {str(name): str(claim["statement"]) for name, claim in ledger.items()}


_CLAIM_COLUMNS = [
    "claim", "statement", "mark", "share", "clear", "choices", "within", "specifications", "placebo", "hangs_on",
    "first", "total", "missing",
]  # fmt: skip


def _described(found: ClaimOutcomes, space: Space) -> pd.DataFrame:
    """Return the specifications of a claim by the names of their choices."""
    wording = found.wording
    rows = [
        (
            wording.name, space.reading(row.reading), wording.measures[row.measure],
            wording.statistics[row.statistic], space.thresholds[row.threshold], row.holds, row.value, row.low, row.high,
            row.what, row.margin, row.certainty,
        )
        for row in found.rows
    ]  # fmt: skip
    return pd.DataFrame(rows, columns=[*_COLUMNS, "what", "margin", "certainty"])


def unselected(specifications: pd.DataFrame) -> pd.DataFrame:
    """Return the specifications without those of triples of readings, which were selected because pairs came near."""
    return specifications[specifications["reading"].str.count(re.escape(AND)) < _EVERY]


def _of_every(found: ClaimOutcomes, space: Space) -> list[Row]:
    """Return the specifications of the readings that every claim is judged under."""
    return [row for row in found.rows if row.reading < space.every]


def _marked(found: ClaimOutcomes, space: Space) -> Marked:
    rows = _of_every(found, space)
    if not any(row.what for row in rows):
        return Marked(Mark.OPEN, np.nan, np.nan)
    holds, certainty = (
        np.array([row.holds is True for row in found.rows]),
        np.array([row.certainty for row in found.rows]),
    )
    first = marked(holds[: len(rows)], certainty[: len(rows)], choices(found.wording, rows, space))
    triples = {
        space.reading(row.reading): np.array([each.reading == row.reading for each in found.rows[len(rows) :]])
        for row in found.rows[len(rows) :]
    }
    return with_triples(first, holds[len(rows) :], certainty[len(rows) :], triples)


def _components(found: ClaimOutcomes, space: Space) -> list[Component]:
    keys = [each.key for each in space.alternatives]
    return decompose(found.verdicts, space.readings[: space.every], keys, ["measure", "statistic", "threshold"])


def _largest(components: Sequence[Component]) -> tuple[str, float, float]:
    """Return the factor that a verdict hangs on most, with its first-order and total shares."""
    factors = dict.fromkeys(factor for part in components for factor in part.factors)
    if not factors:
        return "", np.nan, np.nan
    largest = max(factors, key=lambda factor: total(components, factor))
    return largest, first_order(components, largest), total(components, largest)
