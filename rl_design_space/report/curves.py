"""A figure of learning curves: panels of lines, the share of failed trials, and what a schedule's exploration costs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass as plain_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.study_runs import Runs, Where

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.plan.plan import PlannedPoint
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

Text = Annotated[str, Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Panel:
    """A panel of a figure.

    Attributes:
        title: above it.
        where: what its points have in common.
        lines: points by the name of their line: the values that they have beside.
    """

    title: Text
    where: Where
    lines: Annotated[dict[str, Where], Field(min_length=1)]


@plain_dataclass(frozen=True)
class Line:
    """A line of a panel: its point, and what was recorded of it, if anything was."""

    panel: str
    name: str
    planned: PlannedPoint
    recorded: LearningCurves | None


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CurvesFigure:
    """Learning curves with 95 % bands, beside the optimum and a random walk.

    Attributes:
        title: of the figure.
        shows: what it shows, for those who cannot see it.
        panels: see `Panel`, in their order.
        families: kinds of schedules by name, each the values that its points have in common; if there are any, a row of
            panels shows total steps against total exploration.
    """

    title: Text
    shows: Text
    panels: Annotated[list[dict[str, Any]], Field(min_length=1)]
    families: dict[str, Where] = Field(default_factory=dict)

    def built_panels(self) -> list[Panel]:
        """The panels, validated.

        Raises:
            ConfigError: one is not as it should be.
        """
        return [construct(Panel, node, f"study.report.panels.{i}") for i, node in enumerate(self.panels)]

    def lines(self, runs: Runs) -> list[Line]:
        """All lines in the order of panels.

        Raises:
            ConfigError: the values of a line do not belong to one point.
        """
        lines = []
        for panel in self.built_panels():
            for name, where in panel.lines.items():
                planned = runs.one({**panel.where, **where})
                lines.append(Line(panel.title, name, planned, runs.periods(planned)))
        return lines

    def frame(self, lines: list[Line]) -> pd.DataFrame:
        """What is drawn as curves: a row a panel, line and trial, see `analysis.learning_curves.curve_frame`."""
        import pandas as pd

        from rl_design_space.analysis.learning_curves import curve_frame

        frames = [
            curve_frame(line.recorded).assign(panel=line.panel, line=line.name) for line in lines if line.recorded
        ]
        columns = ["panel", "line", "trial", "mean", "ci_low", "ci_high", "median", "q10", "q90", "failed"]
        return pd.concat(frames)[columns] if frames else pd.DataFrame(columns=columns)

    def exploration_frame(self, runs: Runs) -> pd.DataFrame:
        """What is drawn below: a row a recorded point of the families."""
        import pandas as pd

        from rl_design_space.analysis.learning_curves import curve_summary

        rows = [
            {"panel": panel, "family": family, "point": planned.name, **curve_summary(recorded)}
            for panel, family, planned, recorded in self._family_points(runs)
            if recorded
        ]
        columns = ["panel", "family", "point", "exploration", "total_steps", "total_low", "total_high"]
        return pd.DataFrame(rows, columns=[*columns, "final_over_optimum", "final_low", "final_high", "failed"])

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md, and with families NAME_exploration.csv, into a folder; the paths."""
        from rl_design_space.report.curves_picture import draw
        from rl_design_space.report.curves_text import curves_text
        from rl_design_space.report.heatmap import save

        runs = Runs(study.plan, reader)
        lines = self.lines(runs)
        curves, exploration = self.frame(lines), self.exploration_frame(runs)
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        paths = save(draw(self, lines, curves, exploration), stem, study.mark)
        curves.to_csv(stem.with_suffix(".csv"), index=False)
        if self.families:
            paths.append(folder / f"{study.name}_exploration.csv")
            exploration.to_csv(paths[-1], index=False)
        stem.with_suffix(".md").write_text(curves_text(study, self, lines, runs), encoding="utf-8")
        return [*paths, stem.with_suffix(".csv"), stem.with_suffix(".md")]

    def _family_points(self, runs: Runs) -> Iterator[tuple[str, str, PlannedPoint, LearningCurves | None]]:
        for panel in self.built_panels():
            for family, where in self.families.items():
                for planned in runs.where({**panel.where, **where}):
                    yield panel.title, family, planned, runs.periods(planned)
