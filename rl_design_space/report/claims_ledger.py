"""The ledger of claims: what a text says, and what the measurements say of it."""

from __future__ import annotations

from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from matplotlib.figure import Figure
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.claims import BuiltClaim, built_claims
from rl_design_space.report.claims_judged import (
    Judged,
    TestedParts,
    claims_frame,
    later_findings,
    parts_frame,
    registered_findings,
)
from rl_design_space.report.claims_picture import drawn
from rl_design_space.report.claims_points import LargerSamples, RecordedPoints
from rl_design_space.report.claims_text import counted, paragraphs, verdicts
from rl_design_space.report.larger_samples import larger_samples
from rl_design_space.report.points import smallest
from rl_design_space.report.runs import Runs
from rl_design_space.report.written import MainNumbers, Written
from rl_design_space.tracking.selection import Where

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader

PARTS, LATER_PARTS = "_parts", "_later_parts"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ClaimsLedger(Report):
    """Verdicts on all claims.

    Attributes:
        common: values of parameters that all points have unless a part says otherwise.
        reading: values of parameters that a point has if it has such a parameter at all.
        later_reading: the same for the verdicts that came later; `reading` if left out.
        larger_samples: study with more periods of the points of some claims; none if empty.
        on_larger_samples: claims whose later verdicts rest on these, if they are recorded.
        claims: by name, each with `statement`, `study` (whose table or figure shows it), `parts` (what must hold, each
            an option of `analysis.parts`), `later` (parts that were written when the verdicts on the former were known;
            `parts` if left out), and `awaits` (what has to be there before more can be measured).
    """

    shows: str = "Every part of every claim: its value with the 95 % interval, beside the range that the claim gives"
    common: Where
    reading: Where = field(default_factory=dict)
    later_reading: Where | None = None
    larger_samples: str = ""
    on_larger_samples: Annotated[tuple[str, ...], Field(strict=False)] = ()
    claims: dict[str, dict[str, Any]]

    #: Parts are built here, so that errors name their claim.
    builds_options: ClassVar[bool] = True

    @model_validator(mode="after")
    def _has_valid_claims(self) -> ClaimsLedger:
        built = self.built
        for name in self.on_larger_samples:
            if name not in built:
                raise ConfigError.unknown("on_larger_samples", name, built)
        return self

    def write(self, study: Study, reader: Reader, folder: Path) -> Written:
        runs = Runs.of_study(study, reader)
        if self.larger_samples:
            missing = runs.remarks
            runs = runs.with_larger(*larger_samples(self.larger_samples, study, reader))
            runs.remarks = missing  # larger samples are no part of the study
        return self.write_runs(runs, folder / study.name)

    @cached_property
    def built(self) -> dict[str, BuiltClaim]:
        """The claims with their parts, by name."""
        return built_claims(self.claims)

    @property
    def has_later(self) -> bool:
        """Whether there are verdicts that came later."""
        return self.later_reading is not None or any(each.claim.later is not None for each in self.built.values())

    def judged(self, runs: Runs) -> list[Judged]:
        """Return the verdict on every claim, in their order; claims that lack a point are undecided.

        Raises:
            ConfigError: a part does not name its points.
        """
        built = self.built
        parts = {name: each.registered for name, each in built.items()}
        points = smallest(runs.points)
        first = runs.only(points)
        registered = TestedParts(parts, RecordedPoints(first, self.common, self.reading))
        findings = registered_findings(built, registered)
        judged = [Judged(name, each.claim, findings[name], registered.missing[name]) for name, each in built.items()]
        if not self.has_later:
            return judged
        reading = self.reading if self.later_reading is None else self.later_reading
        data, larger = RecordedPoints(first, self.common, reading), None
        if len(points) < len(runs.points):
            samples = runs.only(set(runs.points).difference(points))
            larger = LargerSamples(samples, self.common, reading, data)
        later = TestedParts({name: each.later for name, each in built.items()}, data, larger, self.on_larger_samples)
        found = later_findings(later)
        return [
            replace(
                each, later=found[each.name], later_missing=later.missing[each.name],
                later_periods=later.periods[each.name],
            )
            for each in judged
        ]  # fmt: skip

    def frames(self, runs: Runs) -> Frames:
        judged = self.judged(runs)
        frames = {MAIN: claims_frame(judged), PARTS: parts_frame(judged)}
        return {**frames, LATER_PARTS: parts_frame(judged, later=True)} if self.has_later else frames

    def draw(self, frames: Frames) -> Figure:
        return drawn(frames[PARTS], frames.get(LATER_PARTS), self.title)

    def main_numbers(self, frames: Frames) -> MainNumbers:
        """Return how many verdicts there are of each kind, and a row for each claim."""
        claims = frames[MAIN]
        return MainNumbers.of(self._in_words(self.heading), counted(claims), frame=verdicts(claims))

    def text(self, frames: Frames) -> list[str]:
        """Return the verdicts, and everything that each of them rests on."""
        return paragraphs(frames[MAIN], frames[PARTS], frames.get(LATER_PARTS))
