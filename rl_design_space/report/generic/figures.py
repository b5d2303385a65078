"""Several figures of one study."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.report.generic.figure import Figure

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader


def _a_figure(value: Any) -> Any:
    if not isinstance(value, Figure):
        raise ValueError("should be a Heatmap, Curves, Sensitivity or Compare of rl_design_space.report")
    return value


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Figures:
    """What a study's file may name as its report, if it wants more than one picture.

    Attributes:
        figures: by their names, which follow the study's in the names of the files.
    """

    figures: Annotated[dict[str, Annotated[Any, AfterValidator(_a_figure)]], Field(min_length=1)]

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write PNG, SVG, CSV and Markdown of each."""
        from rl_design_space.report.generic.selection import Selection

        selection = Selection.of_study(study, reader)
        return [
            path
            for name, figure in self.figures.items()
            for path in figure.write_of(selection, folder / f"{study.name}-{name}")
        ]
