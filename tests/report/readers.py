"""A reader whose runs are learned when they are read, and what tests read of reports."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.learning.stage_record import filed
from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.tracker import StoredRun


def unpadded(text: str) -> str:
    """Return Markdown without the spaces that align the columns of its tables."""
    return re.sub(r" *\| *", " | ", text).replace("\n | ", "\n| ").replace(" | \n", " |\n")


@dataclass
class LearningReader:
    """Runs of all points of a plan but of some."""

    in_flight = 2
    plan: Plan
    missing: Collection[str] = ()
    attached: list[tuple[str, Sequence[Path]]] = field(default_factory=list)

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        there = {planned.fingerprint for planned in self.plan}.difference(self.missing)
        return {fingerprint: StoredRun(fingerprint) for fingerprint in fingerprints if fingerprint in there}

    def periods(self, run: StoredRun) -> dict[str, Any]:
        (planned,) = (planned for planned in self.plan if planned.fingerprint == run.run_id)
        curves: LearningCurves = simulate(planned.point, threads=1)
        return {
            "steps": curves.steps,
            "success": curves.success,
            "optimum": curves.optimum,
            "rows": curves.rows,
            **curves.curves,
            **filed(curves.stages),
        }

    def link(self, ui: str, study: str) -> str:
        return f"{ui}/{study}"

    def attach(self, study: str, paths: Sequence[Path]) -> None:
        self.attached.append((study, paths))
