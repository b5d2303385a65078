"""What each attribute of an observation is worth: what leaving it out costs, and at which stage of the task."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any, ClassVar, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.measure_name import MeasureName
from rl_design_space.design import Representation, Without
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.cells import colour_bar, colour_cells, hatch, write
from rl_design_space.report.markdown import table
from rl_design_space.report.ratios import named, of_periods, ratio
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import interval, number, styled

#: The column of what is left out during the whole task.
ALWAYS = "always"
#: Ratio above which the whole interval lies where leaving an attribute out is said to cost something.
_COSTS = 1.05


class _Less(NamedTuple):
    """A result with less in its observations.

    Attributes:
        of: the representation that observes everything.
        left_out: what is left out.
        stage: success counter at which it is, or `ALWAYS`.
        result: the learning curves.
    """

    of: Representation
    left_out: str
    stage: str
    result: LearningCurves


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Attributes(Report):
    """What leaving attributes out costs: the ratio of a measure to that of the whole observation, over equal periods.

    The points have the representation `Without`, with nothing or one attribute left out, at all success counters or at
    one of them; or the representation that it is of, with other values.

    Attributes:
        value: measure that is compared; its mean over periods.
    """

    value: MeasureName = "total_steps"

    choosable: ClassVar[Sequence[str]] = ("colour_map",)

    def frames(self, runs: Runs) -> Frames:
        """Return representation, left_out, stage, ratio, low, high, failed (share of trials), periods: a row each."""
        whole, less = _found(runs)
        if not whole:
            raise ConfigError("representation.leave_out: no run has the whole observation; should be [] in one of them")
        rows = []
        for each in less:
            if each.of not in whole:
                continue
            known = whole[each.of]
            estimate = ratio(of_periods(each.result, self.value), of_periods(known, self.value))
            failed = 1 - each.result.success.mean()
            about = {"representation": _name(each.of), "left_out": each.left_out, "stage": each.stage}
            rows.append({**about, **named("ratio", estimate), "failed": failed, "periods": len(each.result.steps)})
        if not rows:
            raise ConfigError("representation.leave_out: no run has less than the whole observation")
        return {MAIN: pd.DataFrame(rows)}

    def draw(self, frames: Frames) -> Figure:
        return _draw(frames[MAIN], self)

    def text(self, frames: Frames) -> list[str]:
        main = frames[MAIN]
        lines = [
            {
                "representation": name,
                "left out": left_out,
                **{_heading(stage): _told(each, stage) for stage in _stages(main)},
            }
            for (name, left_out), each in main.groupby(["representation", "left_out"], sort=False)
        ]
        verdicts = [f"- {name}: {_verdict(each)}" for name, each in main.groupby("representation", sort=False)]
        how = (
            f"Ratio of {self.value} to that of the whole observation over the same periods, with 95 % bootstrap "
            "intervals. *always*: left out during the whole task; *counter s*: only while s goals have been reached; "
            "an agent without the counter could not know when that is."
        )
        return [table(pd.DataFrame(lines)), how, "\n".join(verdicts)]


def _found(runs: Runs) -> tuple[dict[Representation, LearningCurves], list[_Less]]:
    """Return the results with whole observations, and those with less.

    Raises:
        ConfigError: several runs have the same whole observation.
    """
    whole: dict[Representation, LearningCurves] = {}
    less: list[_Less] = []
    plain: list[tuple[Any, LearningCurves]] = []
    for point in runs.recorded:
        result, seen = runs.result(point), runs.design_point(point).representation
        if result is None:
            continue
        if not isinstance(seen, Without):
            plain.append((seen, result))
        elif not seen.leave_out:
            if seen.of in whole:
                raise ConfigError(f"{_name(seen.of)}: several runs have the whole observation; choose one design")
            whole[seen.of] = result
        elif len(seen.leave_out) == 1 and len(seen.counters) < 2:
            stage = str(seen.counters[0]) if seen.counters else ALWAYS
            less.append(_Less(seen.of, seen.leave_out[0], stage, result))
    for other, result in plain:
        same = (of for of in whole if isinstance(of, type(other)) and of != other)
        less += [_Less(of, _difference(other, of), ALWAYS, result) for of in same]
    return whole, less


def _difference(other: Any, of: Any) -> str:
    """Return the values in which a representation differs from another one of its class."""
    changed = (field.name for field in fields(other) if getattr(other, field.name) != getattr(of, field.name))
    return ", ".join(f"{name}={getattr(other, name)}" for name in changed)


def _name(representation: Any) -> str:
    """Return the class of a representation, with the values that are not its defaults."""
    changed = _difference(representation, type(representation)())
    return type(representation).__name__ + (f" ({changed})" if changed else "")


def _stages(frame: pd.DataFrame) -> list[str]:
    """Return the stages of the task, the whole of it first."""
    return sorted(set(frame["stage"]), key=lambda stage: (stage != ALWAYS, stage))


def _heading(stage: str) -> str:
    return stage if stage == ALWAYS else f"counter {stage}"


def _of_stage(cells: pd.DataFrame, stage: str) -> dict[Any, Any] | None:
    found = cells[cells["stage"] == stage].to_dict("records")
    return found[0] if found else None


def _told(cells: pd.DataFrame, stage: str) -> str:
    cell = _of_stage(cells, stage)
    return f"{number(cell['ratio'])} ({interval(cell['ratio_low'], cell['ratio_high'])})" if cell else ""


def _verdict(cells: pd.DataFrame) -> str:
    """Return which attributes matter and when, and which do not, as a clause each."""
    return "; ".join(_clauses(cells))


def _clauses(cells: pd.DataFrame) -> Iterator[str]:
    for left_out in dict.fromkeys(cells["left_out"].astype(str)):
        each = cells[cells["left_out"] == left_out]
        costly = each[each["ratio_low"] > _COSTS]
        always = _of_stage(each, ALWAYS)
        stages = [stage for stage in costly["stage"] if stage != ALWAYS]
        when = f", at counter {', '.join(stages)}" if stages else ""
        if always is None:
            continue
        less = f"with {left_out}" if "=" in left_out else f"without {left_out}"
        if always["ratio_low"] > _COSTS or always["ratio_high"] < 1:
            yield f"{less} {number(always['ratio'])} times as much{when}"
        else:
            yield f"{less} no cost can be told ({number(always['ratio'])} times){when}"


@styled()
def _draw(frame: pd.DataFrame, look: Attributes) -> Figure:
    names, stages = list(dict.fromkeys(frame["representation"])), _stages(frame)
    rows = {name: list(dict.fromkeys(frame.loc[frame["representation"] == name, "left_out"])) for name in names}
    norm = LogNorm(min(frame["ratio"].min(), 1), max(frame["ratio"].max(), 1.01))
    height = 0.62 * max(map(len, rows.values())) + 1.7
    figure, axes = plt.subplots(
        1, len(names), figsize=(4.3 * len(names) + 1, height), layout="constrained", squeeze=False
    )
    for axis, name in zip(axes[0], names, strict=True):
        cells = frame[frame["representation"] == name]
        values = cells.pivot_table(index="left_out", columns="stage", values="ratio").reindex(
            rows[name], columns=stages
        )
        inks = colour_cells(axis, values.rename(columns=_heading), norm, colour_map=look.cells_map)
        _write(axis, cells, rows[name], stages, inks)
        axis.set(xlabel="", ylabel="")
        axis.set_title(name, fontsize=10)
    axes[0][0].set_ylabel("left out, or other values")
    how = {"ticks": LogLocator(subs=(1, 2, 5)), "format": lambda each, _: number(each)}
    bar = colour_bar(figure, list(axes[0]), norm, look.cells_map, **how)
    bar.set_label(f"{look.value}, ratio to the whole observation")
    figure.suptitle(look.title, fontsize=11)
    return figure


def _write(axis: Any, cells: pd.DataFrame, rows: Sequence[str], stages: Sequence[str], inks: Any) -> None:
    for y, left_out in enumerate(rows):
        for x, stage in enumerate(stages):
            cell = _of_stage(cells[cells["left_out"] == left_out], stage)
            if cell is None or np.isnan(cell["ratio"]):
                hatch(axis, x, y, "")
                continue
            between = interval(cell["ratio_low"], cell["ratio_high"])
            main = (0.36, f"{number(cell['ratio'])}", {"fontsize": 10, "fontweight": "bold"})
            write(axis, x, y, [main, (0.72, between, {"fontsize": 6.5})], inks[y][x])
