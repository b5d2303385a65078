"""A figure of learning curves: panels of lines, the share of failed trials, and total steps against exploration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.averaging import differing
from rl_design_space.analysis.learning_curves import curve_frame, curve_summary, random_walk_steps
from rl_design_space.config.build import construct
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.measures import FINAL_TRIALS, NEAR
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report, Text
from rl_design_space.report.curves_picture import draw_curves_figure
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Point, Runs, Where
from rl_design_space.report.style import interval

#: Frames beside the main one; only the first is written.
EXPLORATION, LINES, PANELS = "_exploration", "lines", "panels"
_CURVE_COLUMNS = ["panel", "line", "trial", "mean", "ci_low", "ci_high", "median", "q10", "q90", "failed"]
_EXPLORATION_COLUMNS = [
    "panel", "family", "point", "exploration", "total_steps", "total_low", "total_high",
    "final_over_optimum", "final_low", "final_high", "failed",
]  # fmt: skip


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Panel:
    """A panel of a figure.

    Attributes:
        title: above it.
        where: what its points have in common.
        lines: points by the name of their line: the values that each has in addition.
    """

    title: Text
    where: Where
    lines: Annotated[dict[str, Where], Field(min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CurvesFigure(Report):
    """Learning curves with 95 % bands, beside the optimum and a random walk.

    Attributes:
        panels: in their order, each with `title`, `where` (what its points have in common) and `lines` (points by the
            name of their line: the values that each has in addition).
        families: kinds of schedules by name, each the values that its points have in common; if there are any, a row of
            panels shows total steps against total exploration.
    """

    title: Text
    shows: Text
    panels: Annotated[list[dict[str, Any]], Field(min_length=1)]
    families: dict[str, Where] = Field(default_factory=dict)

    def built_panels(self) -> list[Panel]:
        """Return the panels, validated.

        Raises:
            ConfigError: a panel has a value that is not allowed.
        """
        return [construct(Panel, node, f"study.report.panels.{i}") for i, node in enumerate(self.panels)]

    def points(self, runs: Runs) -> dict[tuple[str, str], Point]:
        """Return the point of each line, by the names of its panel and its own.

        Raises:
            ConfigError: the values of a line do not belong to exactly one point.
        """
        return {
            (panel.title, line): runs.one({**panel.where, **where})
            for panel in self.built_panels()
            for line, where in panel.lines.items()
        }

    def frames(self, runs: Runs) -> Frames:
        """Return what is drawn and written.

        Returns:
            MAIN: panel, line, and the columns of `analysis.learning_curves.curve_frame`: one row for each trial of a
                recorded line.
            EXPLORATION: panel, family, point, joined (whether the family varies one parameter alone), and columns of
                `curve_summary`: one row for each recorded point of the families.
            LINES: panel, line, command, and the columns of `curve_summary`, NaN if missing: one row for each line.
            PANELS: panel; optimum and random_walk, steps of a trial, NaN if nothing is recorded.
        """
        points = self.points(runs)
        results = {names: runs.result(point) for names, point in points.items()}
        curves = [
            curve_frame(result).assign(panel=panel, line=line)[_CURVE_COLUMNS]
            for (panel, line), result in results.items()
            if result
        ]
        lines = [
            {
                "panel": panel,
                "line": line,
                "command": points[panel, line].planned.command,
                "total_steps": float("nan"),
                **(curve_summary(result) if result else {}),
            }
            for (panel, line), result in results.items()
        ]
        panels = []
        for panel in self.built_panels():
            recorded = (result for (title, _), result in results.items() if title == panel.title and result)
            panels.append({"panel": panel.title, **_levels(next(recorded, None))})
        return {
            MAIN: pd.concat(curves) if curves else pd.DataFrame(columns=_CURVE_COLUMNS),
            EXPLORATION: self._exploration(runs),
            LINES: pd.DataFrame(lines),
            PANELS: pd.DataFrame(panels),
        }

    def csv(self, frames: Frames) -> Frames:
        curves = {MAIN: frames[MAIN]}
        return curves | {EXPLORATION: frames[EXPLORATION][_EXPLORATION_COLUMNS]} if self.families else curves

    def draw(self, frames: Frames) -> Figure:
        return draw_curves_figure(
            frames[MAIN], frames[LINES], frames[PANELS], frames[EXPLORATION], self.title, list(self.families)
        )

    def text(self, frames: Frames) -> list[str]:
        """The lines in numbers."""
        header = ["panel", "line", "total steps", "95 % interval", "trials to final level", "final steps / optimum"]
        rows = [[line["panel"], line["line"], *_numbers(line)] for line in frames[LINES].to_dict("records")]
        return [
            table(pd.DataFrame(rows, columns=[*header, "failed"])),
            "Total steps: steps of all trials of a period, mean over periods with its 95 % BCa interval. Trials to "
            f"final level: until the mean curve of steps / optimum stays within {NEAR} times its mean over the last "
            f"{FINAL_TRIALS} trials. Failed trials count with the steps up to the step cap.",
        ]

    def _exploration(self, runs: Runs) -> pd.DataFrame:
        rows = []
        for panel in self.built_panels():
            for family, where in self.families.items():
                points = runs.where({**panel.where, **where})
                joined = len(differing([point.parameters for point in points])) <= 1
                for point in points:
                    if result := runs.result(point):
                        names = {"panel": panel.title, "family": family, "point": point.planned.name}
                        rows.append({**names, "joined": joined, **curve_summary(result)})
        return pd.DataFrame(rows, columns=[*_EXPLORATION_COLUMNS, "joined"])


def _levels(result: LearningCurves | None) -> dict[str, float]:
    """Return the steps of a trial of the best policy, and of a random walk, on the layouts of a result."""
    if result is None:
        return {"optimum": float("nan"), "random_walk": float("nan")}
    walk = random_walk_steps(result.point.world, layouts_of(result.point))
    return {"optimum": float(result.optimum.mean()), "random_walk": walk}


def _numbers(line: Mapping[Any, Any]) -> list[str]:
    if pd.isna(line["total_steps"]):
        return [f"missing: `{line['command']}`", "", "", "", ""]
    return [
        f"{line['total_steps']:,.0f}",
        interval(line["total_low"], line["total_high"], ",.0f"),
        f"{line['trials_to_final']:.0f}",
        f"{line['final_over_optimum']:.3f} ({interval(line['final_low'], line['final_high'], '.3f')})",
        f"{line['failed']:.2%} ({interval(line['failed_low'], line['failed_high'], '.2%')})",
    ]
