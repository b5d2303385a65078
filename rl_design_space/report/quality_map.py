"""Convergence speed, solution quality and need for exploration as a graded table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.at_best import Judged, at_best
from rl_design_space.analysis.quality import Quality, quality
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.errors import ConfigError
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.measures import Measure, canonical, measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.differences import differing
from rl_design_space.report.definitions import Found
from rl_design_space.report.graded_table import GradedTable, Measured
from rl_design_space.report.parameters import SEED, text
from rl_design_space.report.points import Point, by_design
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.selection import Where

#: The quantity that is not a measure of the periods.
_EXPLORATION = "sum_of_epsilon"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QualityMap(GradedTable):
    """Rows of points at the best of their schedules.

    Quantities: speed, trials until the median over periods stays near its final level; over_optimum, steps / optimum
    of the last trials; exploration, sum of ε over the trials. Other definitions take any measure, such as
    `gap_closed=0.9`, or sum_of_epsilon, at the schedule that is the best by each of several measures, see
    `analysis.at_best`.

    Attributes:
        rows: by name, each the values that its points have in common.
        reading: values of parameters that the points of the table have if they have such a parameter at all.
        readings: the same for other definitions, by name; that of the table if left out.
        best_by: measures by which the best schedule is chosen for other definitions.
    """

    shows: str = "Measured grade of each column for each row, the number behind it, and the published grade"
    rows: dict[str, Where]
    reading: Where = Field(default_factory=dict)
    readings: dict[str, Where] = Field(default_factory=dict)
    best_by: Annotated[tuple[MeasureName, ...], Field(strict=False, min_length=1)] = ("total_steps",)

    @property
    def quantities(self) -> tuple[str, ...]:
        return ("speed", "over_optimum", "exploration")

    def check_quantity(self, name: str, key: str) -> None:
        """Refuse a quantity of another definition that is neither a measure nor the exploration.

        Raises:
            ConfigError: there is no such quantity.
        """
        if name != _EXPLORATION:
            try:
                canonical(name)
            except ConfigError as error:
                raise ConfigError(f"{key}.of={name}: {error}") from error

    def found(self, runs: Runs) -> Mapping[str, Found]:
        """Return the quantities of each row, by reading and measure of the best schedule."""
        measures = {name: measure(name) for name in sorted(self.defined_quantities() - {_EXPLORATION})}
        # Rows without a parameter of the readings are the same under all of them.
        schedules: dict[tuple[str, tuple[Point, ...]], Mapping[str, LearningCurves]] = {}
        settings = {}
        for reading, values in (self.readings or {"": self.reading}).items():
            read = runs.under(values)
            for best_by in self.best_by:
                keys = {row: (best_by, tuple(read.where(where))) for row, where in self.rows.items()}
                for row, key in keys.items():
                    if key not in schedules:
                        schedules[key] = self._schedules(read, row)
                settings[f"{reading}, best by {best_by}".removeprefix(", ")] = keys
        with ThreadPoolExecutor(available_threads()) as pool:
            judged = pool.map(lambda key: _at_best(schedules[key], measure(key[0]), measures), schedules)
            known = dict(zip(schedules, judged, strict=True))
        return {name: {row: known[key] for row, key in keys.items()} for name, keys in settings.items()}

    def how(self) -> list[str]:
        how = (
            "Each row is taken at its best schedule: the one with the fewest total steps on the periods of even "
            "number. Speed and quality are those of the periods of odd number. The interval of the exploration is that "
            "of choosing again in bootstrap resamples; the share of periods that never get near the optimum has a "
            "Wilson interval."
        )
        others = (
            "Other definitions are taken at the best schedule by each of several measures, and on all periods: each "
            "half of the periods is judged at the schedule that is best on the other half, for five divisions into "
            "halves, and resamples choose again. Exploration is that of the schedule that is best on all periods."
        )
        return [how, others] if self.definitions else [how]

    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        read = runs.under(self.reading)
        schedules = {row: self._schedules(read, row) for row in self.rows}
        return {
            row: as_measured(quality(each), never=len(next(iter(each.values())).epsilon)) if each else {}
            for row, each in schedules.items()
        }

    def _schedules(self, runs: Runs, row: str) -> Mapping[str, LearningCurves]:
        """Return the results of the schedules of a row by their names; nothing if one of them is missing.

        Raises:
            ConfigError: they differ in their number of periods.
        """
        schedules = by_design(runs.where(self.rows[row]))
        names = schedule_names([seeds[0].choices for seeds in schedules])
        results = {name: runs.pooled(seeds) for name, seeds in zip(names, schedules, strict=True)}
        complete = {name: result for name, result in results.items() if result}
        if all(len(seeds) == 1 and seeds[0].any_periods for seeds in schedules):
            common = min((len(result.steps) for result in complete.values()), default=0)
            complete = {name: result.first(common) for name, result in complete.items()}
        if len({len(result.steps) for result in complete.values()}) > 1:
            raise ConfigError(f"{SEED}, task.periods: schedules of {row} differ in this; choose one value")
        return complete if len(complete) == len(results) else {}


def _at_best(
    schedules: Mapping[str, LearningCurves], best_by: Measure, measures: Mapping[str, Measure]
) -> Mapping[str, Estimate | Judged]:
    """Return measures and the exploration at the best schedule.

    Nothing if there are no schedules, or if a measure does not apply to them: they may have fewer trials than it skips.
    """
    try:
        found = at_best(schedules, best_by, measures) if schedules else None
    except ConfigError:
        return {}
    if found is None:
        return {}
    return {**found.measured, _EXPLORATION: found.exploration}


def as_measured(found: Quality, never: float = math.inf) -> Mapping[str, Measured]:
    """Return the quantities of a row as numbers and texts.

    Args:
        found: the quality of the row.
        never: the number of trials that stands for "never": intervals that reach it have no upper end.
    """
    speed, over, far, total = found.speed, found.over_optimum, found.never_near, found.exploration
    latest = math.inf if speed.high >= never else speed.high
    return {
        "speed": Measured(
            speed.value, f"{speed.value:.0f} trials ({speed.low:.0f} – {speed.high:.0f})", speed.low, latest
        ),
        "over_optimum": Measured(
            over.value,
            f"{over.value:.3f} × optimum ({over.low:.3f} – {over.high:.3f})\n"
            f"{far.value:.0%} of periods never near ({far.low:.0%} – {far.high:.0%})",
            *over[1:],
        ),
        "exploration": Measured(
            total.value, f"Σε = {total.value:.1f} ({total.low:.1f} – {total.high:.1f})\nat {found.best}", *total[1:]
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
