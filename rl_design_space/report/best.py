"""The designs that cannot be told from the best, and how much each could lose."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._markdown import escaped
from rl_design_space._strict import STRICT
from rl_design_space.analysis.best import RESAMPLES
from rl_design_space.analysis.statistics import percentile_interval
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.learning.measure_kinds import PeriodMeasure
from rl_design_space.learning.measure_statistics import MEAN
from rl_design_space.learning.measures import canonical, measure
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.best_set import STAR, compared
from rl_design_space.report.designs import Designs, chosen, given_label
from rl_design_space.report.fitting import break_headings
from rl_design_space.report.many import apart
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import label
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import number

#: Designs that are drawn and listed in the text at most.
_DRAWN, _LISTED = 30, 50
#: Inches: height of a row, of each further line of its name, width of a letter, and of names for which there is room.
_ROW, _LINE, _LETTER, _NAMES = 0.27, 0.12, 0.055, 3.2
#: Widths of values and of probabilities, in a picture of its own size and in a narrow one.
_RATIOS = {False: (3, 1), True: (2, 1)}
_ABOUT = "_about"
#: Periods of a tail below which intervals of 95 % and the set hold too seldom, see docs/importance.md.
_ENOUGH = 25
_FOUND = ["value", "low", "high", "in_best_set", "loss_at_most", "probability_best", "periods_to_decide"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Best(Report):
    """Designs by a measure, the best first, and which of them cannot be told from the best at 95 %.

    Attributes:
        value: measure that decides, see docs/reports.md.
        statistic: how the numbers of periods become one: mean, median, iqm or cvar=5; the measure's own if it has one.
        given: values of parameters; only designs that have them count.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    value: MeasureName = "total_steps"
    statistic: str = "mean"
    given: Annotated[dict[str, Any], Field(default_factory=dict)]
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("scale",)

    @property
    def heading(self) -> str:
        return self.title or f"The best designs by {self._measure}{given_label(self.given)}"

    @property
    def _measure(self) -> str:
        return self.value if self.statistic == "mean" else canonical(f"{self.value},statistic={self.statistic}")

    def frames(self, runs: Runs) -> Frames:
        """Return a row a design, the best first.

        The columns are the parameters in which they differ, value, low, high (95 %), in_best_set, loss_at_most,
        probability_best, periods_to_decide.
        """
        designs = Designs(runs, chosen(runs, self.given))
        own = designs.of_own_periods(self._measure, RESAMPLES)
        numbers = own or designs.numbers(self._measure, RESAMPLES)[0]
        periods = designs.most_periods if own else designs.periods
        descending = measure(self._measure).largest_is_best
        found = compared(numbers, periods, self._measure)
        low, high = percentile_interval(numbers.samples)
        names = designs.names
        rows = pd.DataFrame(
            {
                **{name: [each.get(name) for each in designs.parameters] for name in names},
                **dict(zip(_FOUND[:3], (numbers.value, low, high), strict=True)),
                "in_best_set": found.inside,
                "loss_at_most": found.loss_at_most,
                "probability_best": found.probability,
                "periods_to_decide": found.periods,
            }
        )
        rows = rows.sort_values("value", ascending=not descending, kind="stable")
        note = [*designs.remarks(own=own is not None), _of_few(self._measure, designs.periods)]
        about = pd.DataFrame({"periods": [periods], "note": [" ".join(filter(None, note))]})
        return {MAIN: rows.reset_index(drop=True), _ABOUT: about}

    def csv(self, frames: Frames) -> Frames:
        return {MAIN: frames[MAIN]}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self._measure, self)

    def text(self, frames: Frames) -> list[str]:
        """Return the designs of the set and the next ones, and what the columns mean."""
        rows, about = frames[MAIN], frames[_ABOUT].iloc[0]
        listed = rows.head(_LISTED)
        shown = pd.DataFrame(
            {
                "": [STAR if each else "" for each in listed["in_best_set"]],
                "design": _labels(listed),
                self._measure: listed["value"].map(number),
                "95 % interval": list(map(style.interval, listed["low"], listed["high"])),
                "loss at most": listed["loss_at_most"].map(number),
                "probability of being best": listed["probability_best"].map(lambda share: f"{share:.2f}"),
                "periods to decide": listed["periods_to_decide"].map(_periods),
            }
        )
        size = int(rows["in_best_set"].sum())
        what = "1 design is" if size == 1 else f"{size:,} designs are"
        further = int(rows["in_best_set"][_LISTED:].sum())
        marked = f", {further:,} of them {STAR}," if further else ""
        after = f" The {len(rows) - _LISTED:,} designs after these{marked} are in the CSV file."
        hidden = after if len(rows) > _LISTED else ""
        return [
            f"**{what} among the best** ({STAR}): they cannot be told from the best at 95 %.{hidden}",
            table(shown),
            f"By {escaped(measure(self._measure).meaning)}. {about['note']}",
            "The set holds the true best with 95 %, and all *losses at most* hold together with it, however many "
            "designs there are: multiple comparisons with the best (Hsu, Ann. Statist. 12, 1984), the differences "
            "paired by period; docs/decisions/0027-what-matters.md has the details. *Probability of being best*: "
            "share of 1,000 resamples. "
            "*Periods to decide*: with so many, a difference as measured is found with a probability of 80 %.",
        ]

    def numbers(self, frames: Frames) -> list[str]:
        """Return the set, and what would decide."""
        rows = frames[MAIN]
        best = rows[rows["in_best_set"]]
        names = list(_labels(best))
        lines = [f"{len(best):,} of {len(rows):,} designs cannot be told from the best by {self._measure} at 95 %:"]
        for name, row in list(zip(names, best.to_dict("records"), strict=True))[:10]:
            lines.append(
                f"{STAR} {name or 'the design'}: {number(row['value'])} "
                f"({style.interval(row['low'], row['high'])}), loses at most {number(row['loss_at_most'])}"
            )
        if len(best) > 10:
            lines.append(f"and {len(best) - 10:,} more")
        needed = best["periods_to_decide"].replace(np.inf, np.nan).dropna()
        if len(needed):
            more = int(needed.max()) - int(frames[_ABOUT]["periods"][0])
            nearest = int(needed.min()) - int(frames[_ABOUT]["periods"][0])
            lines.append(
                f"about {max(nearest, 0):,} more periods would leave out the next of them, "
                f"{max(more, 0):,} more the last"
            )
        return lines


def _of_few(name: str, periods: int) -> str:
    """Return a sentence if a statistic of a tail rests on so few periods that what is said to hold does less often."""
    measured = measure(name)
    statistic = measured.statistic if isinstance(measured, PeriodMeasure) else MEAN
    share = statistic.high - statistic.low
    if not 0 < share < 0.5 or share * periods >= _ENOUGH:
        return ""
    return (
        f"*{statistic.name}* of {periods:,} periods is the mean of {share * periods:.3g}: with fewer than {_ENOUGH}, "
        "intervals and the set hold less often than in 95 of 100 studies."
    )


def _labels(rows: pd.DataFrame) -> list[str]:
    names = [name for name in rows.columns if name not in _FOUND]
    keys = rows[names].to_dict("records") if names else [{} for _ in range(len(rows))]
    return [
        label([str(name) for name in key if not pd.isna(key[name])], (v for v in key.values() if not pd.isna(v)))
        for key in keys
    ]


def _periods(value: float) -> str:
    return "" if np.isnan(value) else "never: equal" if np.isinf(value) else f"{value:,.0f}"


@style.styled()
def _draw(rows: pd.DataFrame, value: str, look: Best) -> Figure:
    shown = rows.head(_DRAWN)
    names, common = apart(_labels(shown))
    lines = [line for name in names for line in name.split("\n")]
    row = _ROW + _LINE * (max(name.count("\n") for name in names))
    size = 9.5 + max(0.0, max(map(len, lines)) * _LETTER - _NAMES), max(3.0, row * len(shown) + 1.6)
    figure, (left, right) = plt.subplots(
        1, 2, figsize=size, layout="constrained", sharey=True, width_ratios=_RATIOS[look.is_narrow]
    )
    y = np.arange(len(shown))[::-1]
    for inside, colour in ((True, style.DARK_BLUE), (False, "0.6")):
        which = (shown["in_best_set"] == inside).to_numpy()
        reach = style.beyond(shown["low"], shown["value"], shown["high"])[:, which]
        left.errorbar(
            shown["value"][which], y[which], xerr=reach, fmt="*" if inside else "o", markersize=9 if inside else 4,
            color=colour, linewidth=1.2, label=f"{'cannot' if inside else 'can'} be told from the best",
        )  # fmt: skip
        right.barh(y[which], shown["probability_best"][which], color=colour, height=0.6)
    left.set_yticks(y, [name or "the design" for name in names], fontsize=7.5)
    left.set_ylim(-0.7, len(shown) - 0.3)
    if look.is_log(pd.concat([shown["low"], shown["high"]])):
        left.set_xscale("log")
        left.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        left.xaxis.set_minor_formatter(NullFormatter())
    else:
        left.xaxis.set_major_locator(MaxNLocator(5))
    left.xaxis.set_major_formatter(lambda each, _: f"{each:,g}")
    left.set_xlabel(f"{value}, with 95 % intervals of each")
    left.legend(frameon=False, fontsize=8, loc="best")
    right.set_xlabel("probability\nof being best")
    right.set_xlim(0, 1)
    for axis in (left, right):
        style.tidy(axis)
    further = int(rows["in_best_set"][_DRAWN:].sum())
    also = f"; {further:,} more {STAR} are not drawn" if further else ""
    more = f" (the first {len(shown)} of {len(rows):,}{also})" if len(rows) > len(shown) else ""
    figure.suptitle(f"{look.heading}{more}", fontsize=11)
    if common:
        figure.supxlabel(common, fontsize=7.5)
        break_headings(figure)
    return figure
