"""Table 3 as a heatmap: convergence speed, solution quality and need for exploration, measured and graded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.report.grades import Cell, Grading, cells_frame
from rl_design_space.report.study_runs import Runs, Where

if TYPE_CHECKING:
    from rl_design_space.analysis.quality import Quality
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

_COLUMNS = ("convergence speed", "solution quality", "need for exploration")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class QualityMap:
    """Representations at their best schedules.

    Attributes:
        title: of the report.
        rows: representations by name, each the values that its points have in common.
        gradings: how each of the three columns is graded, see `report.grades.Grading`.
        paper: the paper's grades by row and column.
        labels: how names read in the picture.
    """

    title: Annotated[str, Field(min_length=1)]
    rows: dict[str, Where]
    gradings: dict[str, dict[str, Any]]
    paper: dict[str, dict[str, str]]
    labels: dict[str, str]

    def built_gradings(self) -> dict[str, Grading]:
        """The gradings, validated."""
        return {name: construct(Grading, self.gradings[name], f"study.report.gradings.{name}") for name in _COLUMNS}

    def measured(self, runs: Runs) -> dict[str, Quality | None]:
        """What is known of each representation; None if a point of its is missing."""
        from rl_design_space.analysis.quality import quality

        found: dict[str, Quality | None] = {}
        for row, where in self.rows.items():
            points = runs.where(where)
            recorded = {_schedule(planned.parameters): runs.periods(planned) for planned in points}
            complete = {name: periods for name, periods in recorded.items() if periods}
            found[row] = quality(complete) if complete and len(complete) == len(recorded) else None
        return found

    def cells(self, measured: Mapping[str, Quality | None]) -> list[Cell]:
        """The cells of the table, graded."""
        gradings = self.built_gradings()
        numbers = {row: _numbers(found) if found else {} for row, found in measured.items()}
        cells = []
        for column in _COLUMNS:
            least = min((each[column][0] for each in numbers.values() if each), default=math.nan)
            for row, each in numbers.items():
                number, text = each.get(column, (math.nan, "missing"))
                grade = gradings[column].grade(number, least) if each else ""
                cells.append(Cell(row, column, number, text, grade, self.paper[row][column]))
        return cells

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.grades_picture import draw, table_lines
        from rl_design_space.report.heatmap import save
        from rl_design_space.report.markdown import made_by, missing_points

        runs = Runs(study.plan, reader)
        cells = self.cells(self.measured(runs))
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        paths = save(draw(cells, self.title, self.labels), stem, study.mark)
        cells_frame(cells).to_csv(stem.with_suffix(".csv"), index=False)
        lines = [
            f"# {self.title}",
            "",
            f"![Our grades for each representation, the numbers behind them, and the paper's grades]({study.name}.png)",
            "",
            made_by(study),
            "",
            *table_lines(cells, self.built_gradings(), self.labels),
            *missing_points(study, len(runs.missing)),
            "Each representation is taken at its best schedule, linear or exponential: the one with the fewest total "
            "steps on the periods of even number. Speed and quality are those of the periods of odd number. The "
            "interval of the exploration is that of choosing anew in bootstrap resamples; the share of periods that "
            "never get near the optimum has a Wilson interval.",
            "",
        ]
        stem.with_suffix(".md").write_text("\n".join(lines), encoding="utf-8")
        return [*paths, stem.with_suffix(".csv"), stem.with_suffix(".md")]


def _numbers(found: Quality) -> dict[str, tuple[float, str]]:
    """What a cell is graded by, and what it says."""
    speed, over, never, total = found.speed, found.over_optimum, found.never_near, found.exploration
    texts = (
        f"{speed.value:.0f} trials ({speed.low:.0f} – {speed.high:.0f})",
        f"{over.value:.3f} × optimum ({over.low:.3f} – {over.high:.3f})\n"
        f"{never.value:.0%} of periods never near ({never.low:.0%} – {never.high:.0%})",
        f"Σε = {total.value:.1f} ({total.low:.1f} – {total.high:.1f})\nat {found.best}",
    )
    return dict(zip(_COLUMNS, zip((speed.value, over.value, total.value), texts, strict=True), strict=True))


def _schedule(parameters: Mapping[str, Any]) -> str:
    """A schedule by its option and the parameter that varies."""
    values = [f"{name} = {parameters[f'exploration.{name}']:g}" for name in "kl" if f"exploration.{name}" in parameters]
    return f"{parameters['exploration']}, {', '.join(values)}"
