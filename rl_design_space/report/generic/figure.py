"""What the generic reports have in common: a selection of runs in; a picture, a table and a text out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Drawing

    from rl_design_space.plan.study import Study
    from rl_design_space.report.generic.selection import Selection
    from rl_design_space.tracking.read import Reader


class Figure:
    """A picture of runs, with the numbers behind it."""

    @property
    def heading(self) -> str:
        """Its title."""
        raise NotImplementedError

    def frame(self, selection: Selection) -> pd.DataFrame:
        """The numbers, a row for each that the picture shows.

        Raises:
            ConfigError: the runs have no such parameter or value, or cannot be averaged.
        """
        raise NotImplementedError

    def draw(self, frame: pd.DataFrame) -> Drawing:
        """The picture."""
        raise NotImplementedError

    def remarks(self, frame: pd.DataFrame) -> list[str]:
        """What the numbers say, a paragraph each."""
        raise NotImplementedError

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write PNG, SVG, CSV and Markdown, named after a study."""
        from rl_design_space.report.generic.selection import Selection

        return self.write_of(Selection.of_study(study, reader), folder / study.name)

    def write_of(self, selection: Selection, stem: Path) -> list[Path]:
        """Write the same of any runs.

        Args:
            selection: the runs.
            stem: path of the files without their suffix; the folder is made if need be.
        """
        from rl_design_space.report.heatmap import save

        stem.parent.mkdir(parents=True, exist_ok=True)
        frame = self.frame(selection)
        table, text = (stem.with_name(f"{stem.name}{suffix}") for suffix in (".csv", ".md"))
        frame.to_csv(table, index=False)
        parts = [
            f"# {self.heading}",
            f"![{self.heading}]({stem.name}.png)",
            selection.made_by,
            *selection.remarks,
            *self.remarks(frame),
        ]
        text.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
        return [*save(self.draw(frame), stem, selection.mark), table, text]


def number(value: Any) -> str:
    """A measured number as one reads it: three digits at least."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"


def interval(low: float, high: float) -> str:
    """An interval; empty where there is none."""
    return f"{number(low)} – {number(high)}" if not math.isnan(low) else ""
