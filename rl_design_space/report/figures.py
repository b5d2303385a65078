"""Several pictures of one study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.report.base import Report
from rl_design_space.report.runs import Runs
from rl_design_space.report.together import together
from rl_design_space.report.written import Written

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.reader import Reader


def _a_figure(value: Any) -> Any:
    if not isinstance(value, Report):
        raise ValueError("should be a report of one picture, such as Heatmap, Curves, Sensitivity or Compare")
    return value


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Figures:
    """Several reports of the same runs.

    Attributes:
        look: fields of `Look` for all of them, such as `{width: column, labels: {…}}`.
        figures: by their names, which follow the study's in the names of the files.
    """

    look: dict[str, Any] = Field(default_factory=dict)
    figures: Annotated[dict[str, Annotated[Any, AfterValidator(_a_figure)]], Field(min_length=1)]

    def write(self, study: Study, reader: Reader, folder: Path) -> Written:
        """Write the files of each report, see `Report.write`."""
        runs = Runs.of_study(study, reader)
        with together(folder) as new:
            return Written.joined(
                figure.looking(self.look).write_new(runs, folder / f"{study.name}-{name}", new)
                for name, figure in self.figures.items()
            )

    def looking(self, look: Mapping[str, Any]) -> Figures:
        """Return the same figures with other values of the fields of `Look`."""
        return replace(self, look={**self.look, **look})
