"""How much a number depends on one parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.report.generic.figure import Figure, interval, number

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Drawing

    from rl_design_space.report.generic.selection import Selection

#: Lines that have a colour and a name of their own; more are drawn thin and grey, with their median.
_NAMED = 8
#: Ratio of the largest to the least value from which on an axis is logarithmic.
_DECADE = 10
_EVERYTHING = "all runs"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sensitivity(Figure):
    """A number against the values of a parameter, a line for each combination of the other choices.

    Attributes:
        parameter: along the axis.
        value: scalar that is shown, see `LearningCurves.scalars`.
        title: made of the others if empty.
    """

    parameter: str
    value: str = "total_steps"
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value} against {self.parameter}"

    def frame(self, selection: Selection) -> pd.DataFrame:
        """Line, parameter, value, low, high (95 % over periods), runs: a row a point of a line."""
        import pandas as pd

        from rl_design_space.analysis.averaging import differing
        from rl_design_space.report.generic.selection import SEED, label

        points = [point for point in selection.recorded if point.parameters.get(self.parameter) is not None]
        selection.check([self.parameter])
        others = differing([point.parameters for point in points], beside=(self.parameter,))
        others = [name for name in others if name != SEED]
        rows = []
        for key, line in selection.grouped(others, points).items():
            values = selection.grouped([self.parameter], line)
            for (value,), here in values.items() if len(values) > 1 else ():
                estimate = selection.estimate(here, self.value)
                name = label(others, key) or _EVERYTHING
                rows.append({"line": name, self.parameter: value, **estimate._asdict(), "runs": len(here)})
        if not rows:
            raise ConfigError(f"{self.parameter}: no two of these runs differ in it and are equal in everything else")
        return pd.DataFrame(rows)

    def draw(self, frame: pd.DataFrame) -> Drawing:
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt
        import numpy as np
        import seaborn as sns

        from rl_design_space.report.curves_picture import MARKERS, make_logarithmic, tidy
        from rl_design_space.report.generic.selection import text
        from rl_design_space.report.heatmap import SETTINGS

        names = list(frame["line"].unique())
        few = len(names) <= _NAMED
        colours = sns.color_palette("colorblind", len(names)) if few else [(0.6, 0.6, 0.6)] * len(names)
        values = list(frame[self.parameter].unique())
        numeric = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
        with mpl.rc_context(SETTINGS):
            figure, axis = plt.subplots(figsize=(7.5, 4.6), layout="constrained")
            for place, (name, colour) in enumerate(zip(names, colours, strict=True)):
                line = frame[frame["line"] == name]
                x = line[self.parameter] if numeric else [values.index(value) for value in line[self.parameter]]
                beyond = np.nan_to_num([line["value"] - line["low"], line["high"] - line["value"]])
                axis.errorbar(
                    x, line["value"], yerr=np.maximum(beyond, 0) if few else None, color=colour,
                    marker=MARKERS[place % len(MARKERS)] if few else None, markersize=4,
                    linewidth=1.2 if few else 0.6, label=name,
                )  # fmt: skip
            if not few:
                median = frame.groupby(self.parameter, sort=False)["value"].median()
                x = median.index if numeric else [values.index(value) for value in median.index]
                axis.plot(x, median, color="black", linewidth=2, label=f"median of {len(names)} lines")
            if frame["value"].min() > 0 and frame["value"].max() / frame["value"].min() >= _DECADE:
                make_logarithmic(axis)
            if not numeric:
                axis.set_xticks(range(len(values)), [text(value) for value in values])
            elif min(values) > 0 and max(values) / min(values) >= _DECADE:
                axis.set_xscale("log")
                axis.set_xticks(sorted(values), [text(value) for value in sorted(values)], minor=False)
                axis.minorticks_off()
            axis.set_xlabel(self.parameter)
            axis.set_ylabel(self.value)
            axis.set_title(self.heading, fontsize=11)
            tidy(axis)
            handles, labels = axis.get_legend_handles_labels()
            shown = slice(None) if few else slice(-1, None)
            if labels[shown] != [_EVERYTHING]:
                axis.legend(
                    handles[shown], labels[shown], frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1)
                )
        return figure

    def remarks(self, frame: pd.DataFrame) -> list[str]:
        """Of each line the best value, and what the worst loses."""
        from rl_design_space.report.generic.selection import text

        rows = [f"| | least {self.value} at | | most at | | most over least |", f"|{'---|' * 6}"]
        for name, line in frame.groupby("line", sort=False):
            ordered = line.sort_values("value").to_dict("records")
            best, worst = ordered[0], ordered[-1]
            ratio = number(worst["value"] / best["value"]) if best["value"] > 0 else "–"
            ends = [f"{text(end[self.parameter])} | {number(end['value'])} ({interval(end['low'], end['high'])})"
                    for end in (best, worst)]  # fmt: skip
            rows.append(f"| {name} | {' | '.join(ends)} | {ratio} |")
        return ["\n".join(rows), "In brackets: 95 % bootstrap intervals over periods."]
