"""Two choices side by side, everything else equal: how much more one needs than the other, period by period."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import yaml
from matplotlib.figure import Figure
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.averaging import differing, resampled_means
from rl_design_space.analysis.statistics import mean_estimate, percentile_interval
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import label, order
from rl_design_space.report.runs import Point, Runs, stratum
from rl_design_space.report.style import DARK_BLUE, beyond, interval, number, styled, tidy

#: Name of the row of all pairs together.
_ALL = "all pairs"
#: Height of a row and longest side of the picture, in inches.
_HEIGHT, _LONGEST = 0.36, 40


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Compare(Report):
    """Differences of pairs of points that are equal in everything but what is compared.

    Points of equal seed and size meet the same starts and goals, so each period of one is compared with the same
    period of the other: which layouts were drawn does not matter.

    Attributes:
        a: values of parameters, as on the command line: `representation=ad_hoc`; several with spaces between.
        b: values of the same parameters on the other side.
        value: scalar that is compared, see `LearningCurves.scalars`.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    a: str
    b: str
    value: str = "total_steps"
    title: str = ""

    @property
    def heading(self) -> str:
        return self.title or f"{self.value}: {self.b} minus {self.a}"

    def frames(self, runs: Runs) -> Frames:
        """Return pair, a, b, difference (b − a), low, high (95 %, paired), periods: one row a pair, all pairs last."""
        sides = [_wanted(side) for side in (self.a, self.b)]
        compared = {name for side in sides for name in side}
        runs.check(compared)
        ours, theirs = (
            {_rest(point, compared): point for point in runs.recorded if _fits(point, side)} for side in sides
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
            before, after = runs.values(one, self.value), runs.values(other, self.value)
            if before is None or after is None:
                raise ConfigError(f"{self.value}: is not known period by period for {label(others, one.key(others))}")
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
        return {MAIN: pd.DataFrame(rows)}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self.value, self.heading)

    def text(self, frames: Frames) -> list[str]:
        """Return one row for each pair."""
        pairs = frames[MAIN]
        shown = pd.DataFrame(
            {
                "pair": pairs["pair"],
                self.a: pairs["a"].map(number),
                self.b: pairs["b"].map(number),
                "difference": pairs["difference"].map(number),
                "95 % interval": list(map(interval, pairs["low"], pairs["high"])),
                "periods": pairs["periods"],
            }
        )
        return [table(shown), "Paired by period: both sides met the same starts and goals."]


@styled()
def _draw(frame: pd.DataFrame, value: str, title: str) -> Figure:
    height = min(_HEIGHT * len(frame) + 1.6, _LONGEST)
    figure, axis = plt.subplots(figsize=(7.5, height), layout="constrained")
    y = np.arange(len(frame))[::-1]
    reach = beyond(frame["low"], frame["difference"], frame["high"])
    clear = (frame["low"] > 0) | (frame["high"] < 0)
    for which, face in ((clear, DARK_BLUE), (~clear, "white")):
        axis.errorbar(
            frame["difference"][which], y[which], xerr=reach[:, which], fmt="o",
            color=DARK_BLUE, markerfacecolor=face, markersize=5, linewidth=1.2,
        )  # fmt: skip
    axis.axvline(0, color="0.4", linewidth=1)
    axis.set_yticks(y, frame["pair"])
    axis.set_ylim(-0.6, len(frame) - 0.4)
    axis.xaxis.set_major_formatter(lambda number_, _: f"{number_:,g}")
    axis.set_xlabel(f"difference of {value} with its 95 % interval; hollow: the interval contains 0")
    axis.set_title(title, fontsize=11)
    tidy(axis)
    return figure


def _wanted(side: str) -> dict[str, Any]:
    """Return `representation=ad_hoc exploration.k=0.02` as values by name.

    Raises:
        ConfigError: a part has no equals sign.
    """
    wanted = {}
    for part in side.split():
        name, equals, value = part.partition("=")
        if not equals:
            raise ConfigError(f"{side}: should be values of parameters, such as representation=ad_hoc")
        wanted[name] = yaml.safe_load(value)
    return wanted


def _fits(point: Point, wanted: Mapping[str, Any]) -> bool:
    return all(point.parameters.get(name) == value for name, value in wanted.items())


def _rest(point: Point, compared: set[str]) -> tuple[tuple[str, Any], ...]:
    """Return everything in which both points of a pair are equal: all but what is compared and its values."""
    prefixes = tuple(f"{name}." for name in compared)
    rest = {name: value for name, value in point.parameters.items() if name not in compared}
    return tuple(sorted((name, value) for name, value in rest.items() if not name.startswith(prefixes)))
