"""Learning curves by the values of parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.learning.measures import CURVES_OF_PERIODS
from rl_design_space.report.generic.figure import Figure, number
from rl_design_space.report.generic.heatmap import Names

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Drawing

    from rl_design_space._arrays import FloatArray
    from rl_design_space.report.generic.selection import Point, Selection

#: Lines that can be told apart.
_MOST = 12


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Curves(Figure):
    """A line for each value of some parameters, the mean over the runs that have it.

    Attributes:
        by: parameters whose values make the lines.
        curve: which learning curve, see `LearningCurves.curves`.
        mean: whether runs of one line that differ in more than their seed are averaged.
        title: made of the others if empty.
    """

    by: Names
    curve: str = "steps/mean"
    mean: bool = False
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.curve} by {', '.join(self.by)}"

    def frame(self, selection: Selection) -> pd.DataFrame:
        """Line, trial, mean, ci_low, ci_high (95 % over periods), runs: a row a line and trial."""
        import pandas as pd

        from rl_design_space.report.generic.selection import check_averaged, label

        lines = {key: [point for point in points if point.run] for key, points in selection.grouped(self.by).items()}
        lines = {key: points for key, points in lines.items() if points}
        if len(lines) > _MOST:
            raise ConfigError(f"{', '.join(self.by)}: {len(lines)} lines cannot be told apart; choose with --filter")
        parts = []
        for key, points in lines.items():
            name = label(self.by, key)
            check_averaged(points, f"line ({name})", "give them lines with --by", self.mean)
            lengths = {len(selection.curve(point, self.curve)) for point in points}
            if len(lengths) > 1:
                raise ConfigError(
                    f"task.trials: runs of one line ({name}) have {' or '.join(map(str, sorted(lengths)))}"
                )
            mean, low, high = self._line(selection, points)
            part = pd.DataFrame({"mean": mean, "ci_low": low, "ci_high": high}).rename_axis("trial").reset_index()
            parts.append(part.assign(line=name, runs=len(points)))
        columns = ["line", "trial", "mean", "ci_low", "ci_high", "runs"]
        return pd.concat(parts, ignore_index=True)[columns] if parts else pd.DataFrame(columns=columns)

    def _line(self, selection: Selection, points: list[Point]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mean curve of runs, and its interval where the periods are known."""
        import numpy as np

        from rl_design_space.analysis.averaging import resampled_means
        from rl_design_space.analysis.statistics import percentile_interval
        from rl_design_space.report.generic.selection import stratum

        mean: FloatArray = np.mean([selection.curve(point, self.curve) for point in points], axis=0)
        recorded = [selection.periods(point) for point in points]
        nothing = np.full(len(mean), np.nan)
        values = CURVES_OF_PERIODS.get(self.curve)
        if values is None or any(run is None or len(run.steps) < 2 for run in recorded):
            return mean, nothing, nothing
        runs = [np.asarray(values(run), float) for run in recorded if run]
        low, high = percentile_interval(resampled_means(runs, [stratum(point) for point in points]))
        return mean, low, high

    def draw(self, frame: pd.DataFrame) -> Drawing:
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt
        import seaborn as sns

        from rl_design_space.report.curves_picture import DASHES, draw_curve, make_logarithmic, tidy
        from rl_design_space.report.heatmap import SETTINGS

        names = list(frame["line"].unique())
        with mpl.rc_context(SETTINGS):
            figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
            for name, colour, number_ in zip(
                names, sns.color_palette("husl", len(names)), range(len(names)), strict=True
            ):
                draw_curve(axis, frame[frame["line"] == name], colour, DASHES[number_ % len(DASHES)])
                axis.lines[-1].set_label(name)
            if self.curve.startswith("steps/") and len(frame) and frame["mean"].min() > 0:
                make_logarithmic(axis)
            axis.set_xlabel("trial")
            axis.set_ylabel(self.curve)
            axis.set_title(self.heading, fontsize=11)
            tidy(axis)
            if names:
                # Beside the lines, where it hides none.
                axis.legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1))
        return figure

    def remarks(self, frame: pd.DataFrame) -> list[str]:
        """Where each line ends."""
        last = frame.groupby("line", sort=False).last()
        ends = [f"- {name}: {number(row['mean'])}, {int(row['runs'])} runs" for name, row in last.iterrows()]
        return [
            "At the last trial:",
            "\n".join(ends),
            "Bands: 95 % bootstrap intervals over periods, where these are kept.",
        ]
