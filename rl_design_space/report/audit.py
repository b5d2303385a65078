"""The audit of readings: which reading of the paper's text fits its own numbers best."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import scaled_to_equal_steps
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.study_runs import Runs, Where

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space._arrays import FloatArray
    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ReadingsAudit:
    """Readings ranked by how well a published table fits under each.

    Attributes:
        title: of the report.
        table: the study whose report has the published numbers, a `PublishedTable`.
        decided: values of parameters that a point has unless its reading says otherwise.
        readings: what each reading says, by its name.
    """

    title: str
    table: str
    decided: Where
    readings: dict[str, Where]

    def frame(self, runs: Runs, table: PublishedTable) -> pd.DataFrame:
        """One row a reading and panel of the table, the best fit first; readings without all of their cells last.

        Returns:
            reading, panel, cells (recorded), of (published), rms, ci_low, ci_high, bias, bias_low, bias_high, largest;
            the last seven as log ratios, NaN unless all cells are there.
        """
        import pandas as pd

        from rl_design_space.analysis.fit import fit

        columns = ["reading", "panel", "cells", "of", "rms", "ci_low", "ci_high", "bias", "bias_low", "bias_high"]
        rows: list[tuple[Any, ...]] = []
        for panel in table.published:
            decided = self._points(runs, table, panel, {})
            for reading, says in self.readings.items():
                points = self._points(runs, table, panel, says)
                if says and points == decided:
                    continue  # it makes no difference here
                cells = list(_cells(runs, table, panel, points))
                found = [(values, published) for values, published in cells if values is not None]
                numbers: tuple[float, ...] = (float("nan"),) * 7
                if len(found) == len(cells):
                    fitted = fit(found)
                    numbers = (*fitted.rms, *fitted.bias, fitted.largest)
                rows.append((reading, panel, len(found), len(cells), *numbers))
        return pd.DataFrame(rows, columns=[*columns, "largest"]).sort_values(["panel", "rms"], ignore_index=True)

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.audit_page import audit_text, draw
        from rl_design_space.report.heatmap import save

        table, runs = self._published(), Runs(study.plan, reader)
        fits = self.frame(runs, table)
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        pictures = save(draw(fits, table, self.title), stem, study.mark)
        fits.to_csv(stem.with_suffix(".csv"), index=False)
        stem.with_suffix(".md").write_text(audit_text(study, fits, table, self, runs), encoding="utf-8")
        return [*pictures, stem.with_suffix(".csv"), stem.with_suffix(".md")]

    def _published(self) -> PublishedTable:
        from rl_design_space.config.compose import shipped_config
        from rl_design_space.plan.study import load_study

        with shipped_config():
            table = load_study(self.table, ()).report()
        if not isinstance(table, PublishedTable):
            raise ConfigError.at("report.table", self.table, "should be a study whose report is a PublishedTable")
        return table

    def _points(self, runs: Runs, table: PublishedTable, panel: Any, says: Where) -> dict[Any, PlannedPoint]:
        """The points of a panel under a reading, by row and column of the table."""
        wanted = {**self.decided, **says}
        cells = {}
        for planned in runs.plan:
            parameters = planned.parameters
            if all(parameters[name] == value for name, value in wanted.items() if name in parameters):
                here, row, column = (parameters[name] for name in table.axes.values())
                if here == panel:
                    cells[row, column] = planned
        return cells


def _cells(
    runs: Runs, table: PublishedTable, panel: Any, points: dict[Any, PlannedPoint]
) -> Iterator[tuple[FloatArray | None, float]]:
    """The values of each cell's periods, None if they were not recorded, and the published number."""
    for row, columns in table.published[panel].items():
        for column, published in columns.items():
            planned = points.get((row, column))
            recorded = runs.periods(planned) if planned else None
            values = None
            if planned and recorded:
                values = recorded.total_steps
                if table.value == "total_steps_scaled":
                    values = scaled_to_equal_steps(values, planned.point.world.shape[0])
            yield values, published
