"""The ledger of claims: what the paper says, and what the measurements say of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass as plain_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.claims import Finding, Tested, judge
from rl_design_space.config.build import build, construct
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.study_runs import Runs, Where

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

#: Stands for a parameter in which any two points differ.
_ANY = "fingerprint"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Claim:
    """One claim of the paper.

    Attributes:
        statement: what it says.
        study: whose table or figure shows it.
        parts: what must hold, each an option of `analysis.parts`; none if there is nothing to measure.
    """

    statement: Annotated[str, Field(min_length=1)]
    study: Annotated[str, Field(min_length=1)]
    parts: Annotated[tuple[Any, ...], Field(strict=False)]


@plain_dataclass(frozen=True)
class Judged:
    """A claim and what came of it; which points it lacks, if any."""

    name: str
    claim: Claim
    finding: Finding
    missing: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ClaimsLedger:
    """Verdicts on all claims.

    Attributes:
        title: of the report.
        common: values of parameters that all points have unless a part says otherwise.
        claims: by name, see `Claim`.
    """

    title: str
    common: Where
    claims: dict[str, dict[str, Any]]

    def judged(self, runs: Runs) -> list[Judged]:
        """The verdict on every claim, in their order; those that lack a point are undecided.

        Raises:
            ConfigError: a claim is not as it should be, or a part does not name its points.
        """
        data = _RecordedPoints(runs, self.common)
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

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write claims.csv, claims_parts.csv, claims.md and the picture into a folder; the paths written."""
        from rl_design_space.report.heatmap import save
        from rl_design_space.report.ledger_picture import draw
        from rl_design_space.report.ledger_text import ledger_text

        judged = self.judged(Runs(study.plan, reader))
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        pictures = save(draw(parts_frame(judged), self.title), stem, study.mark)
        table, parts, text = stem.with_suffix(".csv"), folder / f"{study.name}_parts.csv", stem.with_suffix(".md")
        claims_frame(judged).to_csv(table, index=False)
        parts_frame(judged).to_csv(parts, index=False)
        text.write_text(ledger_text(study, judged, self.title), encoding="utf-8")
        return [*pictures, table, parts, text]


def claims_frame(judged: Sequence[Judged]) -> pd.DataFrame:
    """One row a claim; its value is that of the part that the verdict hangs on."""
    import pandas as pd

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
    """One row a part of a claim: its value with the interval, and where the claim says that it lies."""
    import pandas as pd

    columns = ["claim", "what", "value", "ci_low", "ci_high", "claimed_low", "claimed_high", "state", "verdict"]
    rows = [
        (
            each.name,
            part.what,
            part.value,
            part.ci_low,
            part.ci_high,
            part.low,
            part.high,
            part.state,
            str(each.finding.verdict),
        )
        for each in judged
        for part in each.finding.parts
    ]
    return pd.DataFrame(rows, columns=columns)


class _RecordedPoints:
    """Gives the parts of claims their points."""

    def __init__(self, runs: Runs, common: Where) -> None:
        self._runs = runs
        self._common = common

    def one(self, where: Where) -> LearningCurves:
        return self._recorded(self._runs.one({**self._common, **where}))

    def by(self, where: Where, parameter: str) -> Mapping[Any, LearningCurves]:
        found = self._runs.where({**self._common, **where})
        if not found:
            asked = " ".join(f"{name}={value}" for name, value in where.items())
            raise LookupError(f"no point of these studies has {asked}")
        values = [p.fingerprint if parameter == _ANY else p.parameters[parameter] for p in found]
        return {value: self._recorded(planned) for value, planned in zip(values, found, strict=True)}

    def _recorded(self, planned: PlannedPoint) -> LearningCurves:
        recorded = self._runs.periods(planned)
        if recorded is None:
            raise LookupError(f"missing: {planned.command}")
        return recorded
