"""How much of the variance between designs is due to each choice, and to pairs of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._ahead import ahead
from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT
from rl_design_space.analysis.factorial import Grids
from rl_design_space.analysis.importance import PAIR, RESAMPLES, Cells, Decomposition, decomposed
from rl_design_space.analysis.scales import SCALES, USUAL, Scale, in_brief, trial_edges
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.learning.measures import measure
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report import style
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.designs import Designs, Numbers, ScaleName, chosen, given_label
from rl_design_space.report.grids import gap_remarks
from rl_design_space.report.markdown import table
from rl_design_space.report.runs import Runs

#: Bins of trials, resamples of each, and numbers of periods that are held in memory for them.
_BINS, _RESAMPLES, _HELD = 20, 200, 60_000_000
#: Effects that are drawn as bars; choices and pairs that have a colour of their own in the stacks.
_BARS, _CHOICES, _PAIRS = 12, 6, 3
#: Inches: height of the stacks below the bars, with their legend.
_STACKS = 5.0
_REST = "all other interactions"
BY_TRIAL = "_by_trial"
#: Of the frame with what is not in a CSV file.
_ABOUT = "_about"
_COLUMNS = ["effect", "share", "low", "high", "total", "total_low", "total_high"]
_NOISE = "nothing can be told from noise"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Importance(Report):
    """Shares of the variance between designs by choice and by pair of choices, in all trials and trial by trial.

    Attributes:
        given: values of parameters; only designs that have them count.
        scale: what a period counts as: log_over_optimum, over_optimum, log_steps, or a measure, see docs/reports.md.
        title: heading of the report and its picture; made of the other fields if empty.
    """

    given: Annotated[dict[str, Any], Field(default_factory=dict)]
    scale: ScaleName = USUAL
    title: str = ""

    choosable: ClassVar[Sequence[str]] = ("colour_map",)
    own: ClassVar[Sequence[str]] = ("scale",)

    @property
    def heading(self) -> str:
        scale = self.words.name(self.scale, in_brief(self.scale))
        return self.title or f"What matters for {scale}{given_label(self.given)}"

    def frames(self, runs: Runs) -> Frames:
        """Return effect, share, low, high, total, total_low, total_high: a row an effect, the largest share first.

        `_by_trial` has first_trial, last_trial, effect, share, low, high, and variance, that of all effects together.
        """
        designs = Designs(runs, chosen(runs, self.given)).sorted()
        grids = designs.grids()
        scale = SCALES.get(self.scale, SCALES[USUAL])
        bins = max(1, min(_BINS, designs.trials, _HELD // (len(designs) * designs.periods)))
        also = _by_trial(scale, bins) if len({each["task.trials"] for each in designs.parameters}) == 1 else None
        numbers, by_trial = designs.numbers(self.scale, RESAMPLES, also)
        whole = decomposed(cells(grids, numbers))
        about = pd.DataFrame(
            [
                {"what": "variance", **whole.variance._asdict(), "note": ""},
                {"what": "rest", **whole.rest._asdict(), "note": ""},
                *({"what": "note", "note": note} for note in [*designs.remarks(), *gap_remarks(grids)]),
            ]
        )
        frames = {MAIN: _frame(whole), _ABOUT: about}
        if by_trial:
            stacked = np.stack(by_trial, axis=1)  # (periods, designs, bins)
            frames[BY_TRIAL] = _trial_frame(grids, stacked, trial_edges(designs.trials, bins), runs)
        return frames

    def csv(self, frames: Frames) -> Frames:
        return {name: frame for name, frame in frames.items() if name != _ABOUT}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames, self)

    def text(self, frames: Frames) -> list[str]:
        """Return the shares, what they are shares of, and which designs they are computed from."""
        variance, rest = (_about(frames, what) for what in ("variance", "rest"))
        notes = [str(note) for note in frames[_ABOUT]["note"] if note]
        found = f"{variance['value']:.4g} ({style.interval(variance['low'], variance['high'])})"
        scale = SCALES[self.scale].meaning if self.scale in SCALES else f"{self.scale}, {measure(self.scale).meaning}"
        percent = pd.DataFrame(
            {
                "effect": frames[MAIN]["effect"],
                "share": frames[MAIN]["share"].map(_percent),
                "95 % interval": list(map(_between, frames[MAIN]["low"], frames[MAIN]["high"])),
                "with all interactions": frames[MAIN]["total"].map(_percent),
                "95 % interval ": list(map(_between, frames[MAIN]["total_low"], frames[MAIN]["total_high"])),
            }
        )
        shares = "Shares of the largest variance that the periods allow" if _is_noise(variance) else "Shares"
        noise = [f"**N{_NOISE[1:]}**: the variance between designs is not distinguishable from 0."]
        steps = [
            f"By trial: steps of neighbouring trials, {len(frames[BY_TRIAL]['first_trial'].unique())} bins, "
            f"on the scale {self.scale if self.scale in SCALES else USUAL}."
        ]
        return [
            *(noise if _is_noise(variance) else []),
            table(percent),
            f"{shares} of the variance {found} between the means of designs, of {scale}. What chance adds to it is "
            "subtracted, so a small share may be negative. `A × B` is what the two explain together beyond the effect "
            f"of each. Interactions of three and more choices: {_percent(rest['value'])} "
            f"({_between(rest['low'], rest['high'])}). Intervals: 95 %, periods resampled, in all designs alike.",
            *(
                steps
                if BY_TRIAL in frames
                else ["There is no picture by trial, because designs differ in their number of trials."]
            ),
            *notes,
        ]

    def numbers(self, frames: Frames) -> list[str]:
        """Return the largest shares."""
        variance = _about(frames, "variance")
        rows = [
            f"{row['effect']}: {_percent(row['share'])} ({_between(row['low'], row['high'])})"
            + ("" if np.isnan(row["total"]) else f", with all interactions {_percent(row['total'])}")
            for row in frames[MAIN].head(5).to_dict("records")
        ]
        return [*([f"{_NOISE}; at most:"] if _is_noise(variance) else []), *rows, *_gaps(frames)]


def cells(grids: Grids, numbers: Numbers) -> list[Cells]:
    """Return the factorials of numbers of designs."""
    return [
        Cells(
            tuple(factor.name for factor in part.factors),
            numbers.value[part.points],
            numbers.samples[:, part.points],
            None if numbers.each is None else numbers.each[:, part.points],
        )
        for part in grids.parts
    ]


def _by_trial(scale: Scale, bins: int) -> Callable[[LearningCurves], FloatArray]:
    return lambda result: scale.by_trial(result, bins).astype(np.float32)


def _frame(whole: Decomposition) -> pd.DataFrame:
    rows = [(each.effect, *each.share, *each.total) for each in whole.effects]
    return pd.DataFrame(rows, columns=_COLUMNS)


def _trial_frame(grids: Grids, values: FloatArray, edges: NDArray[np.intp], runs: Runs) -> pd.DataFrame:
    rows: list[dict[str, Any]] = []
    places = range(values.shape[2])
    # All products of matrices go first: the threads of BLAS wait busily for a while after each.
    of_places = [
        [
            Cells.of_periods(tuple(f.name for f in part.factors), values[:, part.points, place], _RESAMPLES)
            for part in grids.parts
        ]
        for place in places
    ]
    watched = runs.watch(places, "decomposing by trial")
    for place, whole in zip(watched, ahead(decomposed, of_places), strict=True):
        trials = {"first_trial": int(edges[place]), "last_trial": int(edges[place + 1]) - 1}
        rest: list[tuple[str, Estimate]] = [("", whole.rest)] if len(grids.factors) > 2 else []
        for effect, share in [*((each.effect, each.share) for each in whole.effects), *rest]:
            rows.append({**trials, "effect": effect or _REST, **_named(share), "variance": whole.variance.value})
    return pd.DataFrame(rows)


def _named(share: Estimate) -> dict[str, float]:
    return {"share": share.value, "low": share.low, "high": share.high}


@style.styled()
def _draw(frames: Frames, look: Importance) -> Figure:
    shown = frames[MAIN].head(_BARS)
    height = max(3.6, 0.34 * len(shown) + 1.8)
    both = BY_TRIAL in frames
    if both and look.is_narrow:
        figure, axes = plt.subplots(2, 1, figsize=(6.5, height + _STACKS), layout="constrained", squeeze=False)
    else:
        figure, axes = plt.subplots(
            1, 1 + both, figsize=(11.5 if both else 6.5, height), layout="constrained", squeeze=False
        )
    _bars(axes[0, 0], shown, look)
    if both:
        _stacks(axes[-1, -1], frames[BY_TRIAL], list(frames[MAIN]["effect"]), look)
    variance = _about(frames, "variance")
    title = f"{look.heading}: {_NOISE}" if _is_noise(variance) else look.heading
    figure.suptitle(title, fontsize=11)
    return figure


def _bars(axis: Axes, shown: pd.DataFrame, look: Importance) -> None:
    y = np.arange(len(shown))[::-1]
    with_total = shown["total"].notna()
    axis.barh(y[with_total], shown["total"][with_total], height=0.72, color="#bcd3e6", label="with all interactions")
    axis.barh(y, shown["share"], height=0.4, color=style.DARK_BLUE, label="alone")
    for place, which, low, high, colour in (
        (0.28, "total", "total_low", "total_high", "0.45"),
        (0.0, "share", "low", "high", style.ORANGE),
    ):
        known = shown[which].notna()
        reach = style.beyond(shown[low], shown[which], shown[high])[:, known]
        axis.errorbar(
            shown[which][known], y[known] + place, xerr=reach, fmt="none", ecolor=colour, elinewidth=1.2, capsize=2
        )  # fmt: skip
    axis.axvline(0, color="0.4", linewidth=0.8)
    axis.set_yticks(y, shown["effect"])
    axis.xaxis.set_major_formatter(lambda share, _: f"{share:.0%}")
    axis.set_xlabel("share of the variance between designs, with 95 % intervals")
    above: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0, 1), "ncols": 2}
    axis.legend(frameon=False, fontsize=8, **(above if look.is_narrow else {"loc": "lower right"}))
    style.tidy(axis)


def _stacks(axis: Axes, by_trial: pd.DataFrame, ordered: Sequence[str], look: Importance) -> None:
    """Draw the shares of the most important effects on each other, by trial."""
    shares = by_trial.pivot_table(index="first_trial", columns="effect", values="share", sort=False).clip(lower=0)
    means = shares.mean().sort_values(ascending=False)
    alone = [effect for effect in means.index if PAIR not in effect and effect != _REST][:_CHOICES]
    pairs = [effect for effect in means.index if PAIR in effect and means[effect] >= 0.01][:_PAIRS]
    named = [*(effect for effect in ordered if effect in alone), *(effect for effect in ordered if effect in pairs)]
    stack = shares[named].assign(**{_REST: shares.drop(columns=named).sum(axis=1)})
    stack = stack.div(stack.sum(axis=1).replace(0, np.nan), axis=0)
    edges = [*shares.index, by_trial["last_trial"].max() + 1]
    below = np.zeros(len(stack))
    colours = [*look.colours(len(named)), "0.85"]
    scale = look.scale if look.scale in SCALES else USUAL
    for effect, colour in zip(stack.columns, colours, strict=True):
        above = below + stack[effect].fillna(0).to_numpy()
        hatch = "///" if PAIR in effect else None
        axis.stairs(
            above, edges, baseline=below, fill=True, facecolor=colour, edgecolor="white", hatch=hatch, linewidth=0,
            label=effect,
        )  # fmt: skip
        below = above
    axis.set_xlim(edges[0], edges[-1])
    axis.set_ylim(0, 1)
    axis.yaxis.set_major_formatter(lambda share, _: f"{share:.0%}")
    axis.set_xlabel("trial")
    axis.set_ylabel(f"share of the variance of {look.words.name(scale, in_brief(scale))}")
    handles, names = axis.get_legend_handles_labels()
    place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1)}
    lower: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}
    axis.legend(handles[::-1], names[::-1], frameon=False, fontsize=8, **(lower if look.is_narrow else place))


def _about(frames: Frames, what: str) -> Mapping[Any, Any]:
    about = frames[_ABOUT]
    return about[about["what"] == what].to_dict("records")[0]


def _is_noise(variance: Mapping[Any, Any]) -> bool:
    return not variance["low"] > 0


def _gaps(frames: Frames) -> list[str]:
    return [note for note in frames[_ABOUT]["note"] if "nothing can be said" in str(note)]


def _percent(share: float) -> str:
    return "" if np.isnan(share) else f"{100 * share:.1f} %"


def _between(low: float, high: float) -> str:
    return "" if np.isnan(low) else f"{100 * low:.1f} – {100 * high:.1f} %"
