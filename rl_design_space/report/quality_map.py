"""Convergence speed, solution quality and need for exploration as a graded table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.quality import Quality, quality
from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report.definitions import Found
from rl_design_space.report.graded_table import GradedTable, Measured
from rl_design_space.report.parameters import SEED, text
from rl_design_space.report.points import by_design
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.selection import Where


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QualityMap(GradedTable):
    """Rows of points at the best of their schedules.

    Quantities: speed, trials until the median over periods stays near its final level; over_optimum, steps / optimum
    of the last trials; exploration, sum of ε over the trials.

    Attributes:
        rows: by name, each the values that its points have in common.
    """

    shows: str = "Measured grade of each column for each row, the number behind it, and the published grade"
    rows: dict[str, Where]

    @property
    def quantities(self) -> tuple[str, ...]:
        return ("speed", "over_optimum", "exploration")

    def found(self, runs: Runs) -> Mapping[str, Found]:
        return {}

    def how(self) -> list[str]:
        how = (
            "Each row is taken at its best schedule: the one with the fewest total steps on the periods of even "
            "number. Speed and quality are those of the periods of odd number. The interval of the exploration is that "
            "of choosing again in bootstrap resamples; the share of periods that never get near the optimum has a "
            "Wilson interval."
        )
        return [how]

    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        found: dict[str, Mapping[str, Measured]] = {}
        for row, where in self.rows.items():
            schedules = by_design(runs.where(where))
            names = schedule_names([seeds[0].parameters for seeds in schedules])
            results = {name: runs.pooled(seeds) for name, seeds in zip(names, schedules, strict=True)}
            complete = {name: result for name, result in results.items() if result}
            if len({len(result.steps) for result in complete.values()}) > 1:
                raise ConfigError(f"{SEED}, task.periods: schedules of {row} differ in this; choose one value")
            found[row] = as_measured(quality(complete)) if complete and len(complete) == len(results) else {}
        return found


def as_measured(found: Quality) -> Mapping[str, Measured]:
    """Return the quantities of a row as numbers and texts."""
    speed, over, never, total = found.speed, found.over_optimum, found.never_near, found.exploration
    return {
        "speed": Measured(speed.value, f"{speed.value:.0f} trials ({speed.low:.0f} – {speed.high:.0f})"),
        "over_optimum": Measured(
            over.value,
            f"{over.value:.3f} × optimum ({over.low:.3f} – {over.high:.3f})\n"
            f"{never.value:.0%} of periods never near ({never.low:.0%} – {never.high:.0%})",
        ),
        "exploration": Measured(
            total.value, f"Σε = {total.value:.1f} ({total.low:.1f} – {total.high:.1f})\nat {found.best}"
        ),
    }


def schedule_names(points: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return short names that tell points apart: their schedules, and other choices in which they differ.

    Args:
        points: by their parameters.
    """
    names = dict.fromkeys(["exploration", *differing(points)])
    return [", ".join(_short(name, point[name]) for name in names if point.get(name) is not None) for point in points]


def _short(name: str, value: Any) -> str:
    """Return `exploration=linear` as `linear`, and `exploration.k=0.03` as `k = 0.03`."""
    return value if isinstance(value, str) and "." not in name else f"{name.rpartition('.')[2]} = {text(value)}"
