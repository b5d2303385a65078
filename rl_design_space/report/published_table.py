"""A published table, measured: heatmap, CSV and Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import scaled_to_equal_steps

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

Axis = Annotated[dict[str, str], Field(min_length=1, max_length=1)]
#: A mean is called heavy-tailed where the 1 % of periods with most steps need this many times the mean.
HEAVY_TAIL = 3


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PublishedTable:
    """Cells of a table in the paper beside the same cells measured.

    Attributes:
        title: of the picture.
        value: what a period contributes to its cell.
        panel, row, column: each one pair, the column's name in the CSV and the parameter of the points behind it.
        labels: how names and values read in the picture.
        published: the paper's number by panel, row and column.
    """

    title: str
    value: Literal["total_steps", "total_steps_scaled"]
    panel: Axis
    row: Axis
    column: Axis
    labels: dict[str, str]
    published: dict[Any, dict[Any, dict[Any, float]]]

    @property
    def axes(self) -> dict[str, str]:
        """CSV column: parameter, of panel, row and column in this order."""
        return {**self.panel, **self.row, **self.column}

    def frame(self, plan: Sequence[PlannedPoint], reader: Reader) -> pd.DataFrame:
        """The cells, published and measured, see `analysis.published`; `planned` tells those that the plan makes.

        Raises:
            ConfigError: several points of the plan are one cell, or a point has no such parameter.
        """
        import pandas as pd

        from rl_design_space.analysis.published import compare_with_published

        self._check_cells(plan)
        runs = reader.finished([planned.fingerprint for planned in plan])
        frames = [
            self._periods(planned, reader.periods(runs[planned.fingerprint]))
            for planned in plan
            if planned.fingerprint in runs
        ]
        empty = pd.DataFrame(columns=[*self.axes, "value", "failed"])
        cells = compare_with_published(pd.concat(frames) if frames else empty, self._published_cells())
        asked_for = {self._cell(planned) for planned in plan}
        return cells.assign(
            planned=[key in asked_for for key in cells[[*self.axes]].itertuples(index=False, name=None)]
        )

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.heatmap import draw, save
        from rl_design_space.report.markdown import published_table_text

        name, cells = study.name, self.frame(study.plan, reader)
        folder.mkdir(parents=True, exist_ok=True)
        pictures = save(draw(cells, self), folder / name, study.mark)
        table, text = folder / f"{name}.csv", folder / f"{name}.md"
        cells.drop(columns=["top_percent", "planned"]).to_csv(table, index=False)
        text.write_text(published_table_text(study, cells, self), encoding="utf-8")
        return [*pictures, table, text]

    def label(self, value: object) -> str:
        """How a name or value reads in the picture."""
        return self.labels.get(str(value), str(value))

    def _periods(self, planned: PlannedPoint, arrays: Mapping[str, Any]) -> pd.DataFrame:
        import pandas as pd

        value = arrays["steps"].sum(axis=1, dtype=float)
        if self.value == "total_steps_scaled":
            value = scaled_to_equal_steps(value, planned.point.world.shape[0])
        keys = dict(zip(self.axes, self._cell(planned), strict=True))
        return pd.DataFrame({**keys, "value": value, "failed": ~arrays["success"].all(axis=1)})

    def _cell(self, planned: PlannedPoint) -> tuple[Any, ...]:
        """The cell that a point is: panel, row and column."""
        parameters = planned.parameters
        for parameter in self.axes.values():
            if parameter not in parameters:
                raise ConfigError.unknown("parameter of its points", parameter, parameters)
        values = (parameters[parameter] for parameter in self.axes.values())
        return tuple(str(value) if isinstance(value, list) else value for value in values)

    def _check_cells(self, plan: Sequence[PlannedPoint]) -> None:
        """Periods of different points must not be averaged into one cell."""
        seen: dict[tuple[Any, ...], PlannedPoint] = {}
        for planned in plan:
            first = seen.setdefault(self._cell(planned), planned)
            differ = [name for name, value in planned.parameters.items() if first.parameters.get(name) != value]
            if first is not planned:
                raise ConfigError(f"{', '.join(differ)}: several values for one cell of the table; choose one of them")

    def _published_cells(self) -> pd.DataFrame:
        import pandas as pd

        rows = [
            (panel, row, column, value)
            for panel, panel_rows in self.published.items()
            for row, columns in panel_rows.items()
            for column, value in columns.items()
        ]
        return pd.DataFrame(rows, columns=[*self.axes, "paper"])
