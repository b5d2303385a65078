"""Why trials fail: the periods in the heavy tails, learned again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.endings import ENDINGS, LAST, NOT_LEARNED, NOT_REPRESENTED, OPEN
from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.failures_examined import Examined, examined
from rl_design_space.report.failures_picture import draw_failures
from rl_design_space.report.markdown import table
from rl_design_space.report.parameters import PERIODS as SIZE
from rl_design_space.report.parameters import label
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs

#: Frames beside the main one: a row for each period examined, for each of their failed trials; and examples that the
#: picture shows, which are not written.
PERIODS, TRIALS, EXAMPLES = "_periods", "_trials", "examples"
#: Designs that a picture shows, at most.
_DRAWN = 9


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Failures(Report):
    """Heavy tails looked into: how failed trials end, and whether the representation could do better.

    The tail of a design is the share of its periods that take most steps. Its periods are learned again, which takes
    milliseconds, and the paths of their failed trials are followed to the end. For each of their layouts the best
    deterministic memoryless policy is searched: one action for each observation. If it reaches the final goal, the
    trial failed because this was not learned; if it is proven that none does, the representation cannot express one.

    Attributes:
        tail: percentage of the periods that make the tail of a design.
        most: number of periods of a tail that are examined, evenly spaced.
        title: heading of the report and its picture.
    """

    title: str = "Why trials fail"
    tail: Annotated[float, Field(gt=0, le=100)] = 5.0
    most: Annotated[int, Field(ge=1)] = 100

    @property
    def heading(self) -> str:
        return self.title or "Why trials fail"

    choosable: ClassVar[Sequence[str]] = ("order",)

    def frames(self, runs: Runs) -> Frames:
        """Return what was found.

        Returns:
            MAIN: design; periods, tail_periods, examined; tail_share of all steps; failed_periods, a share; of the
                failed trials of the periods examined: failed_trials, their number, without_exploration, a share, each
                kind of ending, a share, circle, the median length, stays, the mean; memoryless_over_optimum, the mean
                over the periods examined where the best policy is known; and numbers of periods by verdict.
            PERIODS: design, period, total_steps, optimum, trials, failed_trials, memoryless_steps (NaN if none was
                found), memoryless_bound, verdict (empty if no trial failed).
            TRIALS: design, period, trial, epsilon, and the fields of `analysis.endings.Ending`; observation is a code,
                and observation_cells the number of states that have it.
            EXAMPLES: design, inside (`Replay`), trial.

        Raises:
            ConfigError: a run did not keep its periods, or was learned by other code.
        """
        recorded = [point for point in runs.points if point.run]
        if not recorded:
            raise ConfigError("no run was selected; `rl-design-space store status` says what is recorded")
        names = _names(recorded)
        recorded.sort(key=lambda point: runs.ordering.keys(names, point.key(names)))
        designs, periods, trials, examples = [], [], [], []
        for point in runs.watch(recorded, "learning periods again"):
            name = label(names, point.key(names)) or "the runs"
            found = examined(runs, point, self.tail, self.most)
            runs.forget(point)
            designs.append({"design": name, **found.design, **_summary(found)})
            periods += [{"design": name, **row} for row in found.periods]
            trials += [{"design": name, **row} for row in found.trials]
            if found.example is not None:
                examples.append({"design": name, "inside": found.example, "trial": found.trial})
        return {
            MAIN: pd.DataFrame(designs),
            PERIODS: pd.DataFrame(periods),
            TRIALS: pd.DataFrame(trials),
            EXAMPLES: pd.DataFrame(examples, columns=["design", "inside", "trial"]),
        }

    def csv(self, frames: Frames) -> Frames:
        return {name: frame for name, frame in frames.items() if name != EXAMPLES}

    def draw(self, frames: Frames) -> Figure:
        heaviest = frames[MAIN].sort_values("failed_periods", ascending=False, kind="stable").head(_DRAWN)
        shown = frames[MAIN].loc[sorted(heaviest.index)]
        return draw_failures(shown, frames[PERIODS], frames[EXAMPLES], self.heading)

    def text(self, frames: Frames) -> list[str]:
        """Return the designs in numbers, and what the columns mean."""
        main = frames[MAIN]
        rows = [_row(design) for design in main.to_dict("records")]
        examined_ = int(main["examined"].sum())
        counts = {name: int(main[name].sum()) for name in (NOT_LEARNED, NOT_REPRESENTED, OPEN)}
        told = ", ".join(f"{name} {count:,}" for name, count in counts.items())
        return [
            table(pd.DataFrame(rows)),
            f"Of {sum(counts.values()):,} periods with a failed trial, of {examined_:,} examined: {told}.",
            *self._left_out(main),
            f"The tail is the {self.tail:g} % of the periods that take most steps; of its periods up to {self.most} "
            f"are learned again. A failed trial is judged by its last {LAST:,} steps: a *circle* passes exactly the "
            "same states again and again; *in one observation* means that all these steps begin with the same. "
            "*Stays* is the share of steps after which the observation is the same as before: the value of such an "
            "observation feeds on itself.",
            "*Best memoryless* is the deterministic policy with one action for each observation that needs the fewest "
            "steps in this layout, found by branch and bound, over the optimum. Where it reaches the final goal, a "
            "failure is *not learned*; where it is proven that none does, it *cannot be represented*; otherwise it is "
            "*open*.",
        ]

    def _left_out(self, designs: pd.DataFrame) -> list[str]:
        """Return what picture and text leave out, as a paragraph; none if they show everything."""
        of_tails, learned, notes = int(designs["tail_periods"].sum()), int(designs["examined"].sum()), []
        if learned < of_tails:
            notes.append(
                f"{learned:,} of the {of_tails:,} periods of the tails are examined, evenly spaced from the most steps "
                f"to the least: at most {self.most} of a design."
            )
        if len(designs) > _DRAWN:
            notes.append(
                f"The picture shows the {_DRAWN} of {len(designs)} designs with the most failed periods; table and CSV "
                "files have the others."
            )
        return [" ".join(notes)] if notes else []


def _names(points: Sequence[Point]) -> list[str]:
    """Return the parameters that tell points apart, without the number of periods where the others do."""
    names = list(differing([point.parameters for point in points]))
    others = [name for name in names if name != SIZE]
    return others if len({point.key(others) for point in points}) == len(points) else names


def _summary(found: Examined) -> dict[str, Any]:
    """Return the numbers of a design over the periods examined and their failed trials."""
    trials = pd.DataFrame(found.trials, columns=["epsilon", "ending", "circle", "stays"])
    periods = pd.DataFrame(found.periods)
    circles = trials["circle"][trials["circle"] > 0]
    shares = {kind: float((trials["ending"] == kind).mean()) if len(trials) else np.nan for kind in ENDINGS}
    return {
        "failed_trials": len(trials),
        "without_exploration": float((trials["epsilon"] == 0).mean()) if len(trials) else np.nan,
        **shares,
        "circle": float(circles.median()) if len(circles) else np.nan,
        "stays": float(trials["stays"].mean()) if len(trials) else np.nan,
        "memoryless_over_optimum": float((periods["memoryless_steps"] / periods["optimum"]).mean()),
        **{name: int((periods["verdict"] == name).sum()) for name in (NOT_LEARNED, NOT_REPRESENTED, OPEN)},
    }


def _row(design: dict[Any, Any]) -> dict[str, str]:
    def share(name: str) -> str:
        return "" if pd.isna(design[name]) else f"{design[name]:.0%}"

    over = design["memoryless_over_optimum"]
    return {
        "design": design["design"],
        "periods": f"{design['periods']:,}",
        "with a failed trial": f"{design['failed_periods']:.1%}",
        "steps in the tail": share("tail_share"),
        "failed trials examined": f"{design['failed_trials']:,}",
        "without exploration": share("without_exploration"),
        **{kind: share(kind) for kind in ENDINGS},
        "median circle": "" if pd.isna(design["circle"]) else f"{design['circle']:.0f}",
        "stays": share("stays"),
        "best memoryless / optimum": "not known" if pd.isna(over) else f"{over:.3f}",
    }
