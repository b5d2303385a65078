"""A published table, measured: heatmap, CSV and Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space.design._fields import STRICT
from rl_design_space.learning.curves import scaled_to_equal_steps

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.sweep.plan import PlannedPoint
    from rl_design_space.sweep.study import Study
    from rl_design_space.tracking.read import RunReader

Axis = Annotated[dict[str, str], Field(min_length=1, max_length=1)]
#: A mean is called heavy-tailed where the 1 % of periods with most steps make this share of all steps.
HEAVY_TAIL = 0.03


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

    def frame(self, plan: Sequence[PlannedPoint], reader: RunReader) -> pd.DataFrame:
        """The cells, published and measured; see `analysis.published`."""
        import pandas as pd

        from rl_design_space.analysis.published import compare_with_published

        runs = reader.finished([planned.fingerprint for planned in plan])
        frames = [
            self._periods(planned, reader.periods(runs[planned.fingerprint]))
            for planned in plan
            if planned.fingerprint in runs
        ]
        empty = pd.DataFrame(columns=[*self.axes, "value", "failed"])
        return compare_with_published(pd.concat(frames) if frames else empty, self._published_cells())

    def write(self, study: Study, reader: RunReader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.heatmap import draw, save
        from rl_design_space.report.markdown import published_table_text

        name, cells = study.name, self.frame(study.plan, reader)
        folder.mkdir(parents=True, exist_ok=True)
        pictures = save(draw(cells, self), folder / name)
        table, text = folder / f"{name}.csv", folder / f"{name}.md"
        cells.drop(columns="top_percent").to_csv(table, index=False)
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
        keys = {name: planned.parameters[parameter] for name, parameter in self.axes.items()}
        return pd.DataFrame({**keys, "value": value, "failed": ~arrays["success"].all(axis=1)})

    def _published_cells(self) -> pd.DataFrame:
        import pandas as pd

        rows = [
            (panel, row, column, value)
            for panel, panel_rows in self.published.items()
            for row, columns in panel_rows.items()
            for column, value in columns.items()
        ]
        return pd.DataFrame(rows, columns=[*self.axes, "paper"])
