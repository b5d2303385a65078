"""Two choices beside each other, all else equal: what one needs more than the other, period by period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import yaml
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.errors import ConfigError
from rl_design_space.report.generic.figure import Figure, interval, number

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as Drawing

    from rl_design_space.report.generic.selection import Point, Selection

#: What is said of all pairs together.
_ALL = "all pairs"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Compare(Figure):
    """Differences of pairs of points that are equal in everything but what is compared.

    Points of equal seed and size meet the same starts and goals, so each period of one is compared with the same
    period of the other, and luck of the layout drops out.

    Attributes:
        a: values of parameters, as on the command line: `representation=ad_hoc`; several with spaces between.
        b: the same for the other side.
        value: scalar that is compared, see `LearningCurves.scalars`.
        title: made of the others if empty.
    """

    a: str
    b: str
    value: str = "total_steps"
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value}: {self.b} minus {self.a}"

    def frame(self, selection: Selection) -> pd.DataFrame:
        """Pair, a, b, difference (b − a), low, high (95 %, paired by period), periods; all pairs together last."""
        import pandas as pd

        from rl_design_space.analysis.averaging import differing, resampled_means
        from rl_design_space.analysis.statistics import mean_estimate, percentile_interval
        from rl_design_space.report.generic.selection import label, order, stratum

        sides = [_wanted(text) for text in (self.a, self.b)]
        compared = {name for side in sides for name in side}
        selection.check(compared)
        ours, theirs = (
            {_rest(point, compared): point for point in selection.recorded if _fits(point, side)} for side in sides
        )
        pairs = [(ours[key], theirs[key]) for key in ours if key in theirs]
        if not pairs:
            raise ConfigError(
                f"{self.a}, {self.b}: no two runs are equal in everything else ({len(ours)} and {len(theirs)} runs)"
            )
        others = differing([one.parameters for one, _ in pairs], beside=compared)
        pairs.sort(key=lambda pair: [order(value) for value in pair[0].key(others)])
        rows, differences, strata = [], [], []
        for one, other in pairs:
            before, after = selection.values(one, self.value), selection.values(other, self.value)
            if before is None or after is None:
                raise ConfigError(f"{self.value}: cannot be told period by period of {label(others, one.key(others))}")
            estimate = mean_estimate(after - before)
            differences.append(after - before)
            strata.append(stratum(one))
            rows.append(
                {
                    "pair": label(others, one.key(others)) or "the pair",
                    "a": before.mean(), "b": after.mean(), "difference": estimate.value,
                    "low": estimate.low, "high": estimate.high, "periods": len(before),
                }
            )  # fmt: skip
        if len(pairs) > 1:
            low, high = percentile_interval(resampled_means(differences, strata))
            means = {name: sum(row[name] for row in rows) / len(rows) for name in ("a", "b", "difference")}
            rows.append({"pair": _ALL, **means, "low": low, "high": high, "periods": sum(map(len, differences))})
        return pd.DataFrame(rows)

    def draw(self, frame: pd.DataFrame) -> Drawing:
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt
        import numpy as np

        from rl_design_space.report.curves_picture import tidy
        from rl_design_space.report.heatmap import SETTINGS

        with mpl.rc_context(SETTINGS):
            figure, axis = plt.subplots(figsize=(7.5, min(0.36 * len(frame) + 1.6, 40)), layout="constrained")
            y = np.arange(len(frame))[::-1]
            beyond = np.nan_to_num([frame["difference"] - frame["low"], frame["high"] - frame["difference"]])
            clear = (frame["low"] > 0) | (frame["high"] < 0)
            for which, face in ((clear, "#1f4e79"), (~clear, "white")):
                axis.errorbar(
                    frame["difference"][which], y[which], xerr=np.maximum(beyond, 0)[:, which], fmt="o",
                    color="#1f4e79", markerfacecolor=face, markersize=5, linewidth=1.2,
                )  # fmt: skip
            axis.axvline(0, color="0.4", linewidth=1)
            axis.set_yticks(y, frame["pair"])
            axis.set_ylim(-0.6, len(frame) - 0.4)
            axis.xaxis.set_major_formatter(lambda value, _: f"{value:,g}")
            axis.set_xlabel(f"difference of {self.value}, 95 % interval; hollow: may be none")
            axis.set_title(self.heading, fontsize=11)
            tidy(axis)
        return figure

    def remarks(self, frame: pd.DataFrame) -> list[str]:
        """A row a pair."""
        rows = [f"| | {self.a} | {self.b} | difference | 95 % interval | periods |", f"|{'---|' * 6}"]
        for row in frame.to_dict("records"):
            numbers = [number(row[name]) for name in ("a", "b", "difference")]
            rows.append(
                f"| {row['pair']} | {' | '.join(numbers)} | {interval(row['low'], row['high'])} | {row['periods']} |"
            )
        return ["\n".join(rows), "Paired by period: both sides met the same starts and goals."]


def _wanted(text: str) -> dict[str, Any]:
    """`representation=ad_hoc exploration.k=0.02` as values by name.

    Raises:
        ConfigError: it looks otherwise.
    """
    wanted = {}
    for part in text.split():
        name, equals, value = part.partition("=")
        if not equals:
            raise ConfigError(f"{text}: should be values of parameters, such as representation=ad_hoc")
        wanted[name] = yaml.safe_load(value)
    return wanted


def _fits(point: Point, wanted: Mapping[str, Any]) -> bool:
    return all(point.parameters.get(name) == value for name, value in wanted.items())


def _rest(point: Point, compared: set[str]) -> tuple[tuple[str, Any], ...]:
    """Everything in which the two points of a pair are equal: not what is compared, nor the values of such options."""
    prefixes = tuple(f"{name}." for name in compared)
    rest = {name: value for name, value in point.parameters.items() if name not in compared}
    return tuple(sorted((name, value) for name, value in rest.items() if not name.startswith(prefixes)))
