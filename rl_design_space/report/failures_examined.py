"""The periods in the heavy tail of a design, learned again and examined."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rl_design_space._arrays import IntArray
from rl_design_space.analysis.endings import ending, verdict
from rl_design_space.design import refuse_chance
from rl_design_space.errors import ConfigError
from rl_design_space.learning.memoryless import Memoryless, best_memoryless
from rl_design_space.learning.replay import Replay, Replayer
from rl_design_space.report.points import Point
from rl_design_space.report.runs import Runs


@dataclass(frozen=True)
class Examined:
    """What was found in the heavy tail of a design.

    Attributes:
        design: numbers of the design.
        periods: a row for each period examined.
        trials: a row for each of their failed trials.
        example: the worst of these periods with a failed trial that ends as most of them do; None if none has failed.
        trial: its last trial that ends so.
    """

    design: dict[str, Any]
    periods: list[dict[str, Any]]
    trials: list[dict[str, Any]] = field(default_factory=list)
    example: Replay | None = None
    trial: int = 0


def tail_of(total_steps: IntArray, share: float, most: int) -> tuple[IntArray, IntArray]:
    """Return the periods of a heavy tail, the worst first, and those of them that are examined, evenly spaced.

    Args:
        total_steps: (periods,)
        share: of all periods, in percent.
        most: number of periods that are examined.
    """
    size = max(1, round(share / 100 * len(total_steps)))
    tail: IntArray = np.argsort(-total_steps, kind="stable")[:size]
    return tail, tail[np.unique(np.linspace(0, size - 1, min(most, size)).round().astype(int))]


def examined(runs: Runs, point: Point, share: float, most: int) -> Examined:
    """Learn periods in the heavy tail of a recorded point again.

    Args:
        runs: the runs of the report.
        point: a recorded point.
        share: of the periods that make the tail, in percent.
        most: number of periods that are examined.

    Raises:
        ConfigError: the run did not keep its periods, or was learned by other code.
    """
    result = runs.result(point)
    assert result is not None
    total = result.steps.sum(axis=1, dtype=np.float64)
    tail, chosen = tail_of(total, share, most)
    failed = ~result.success
    design_point = runs.design_point(point)
    # As many as were recorded: a point whose periods are no choice may have others.
    refuse_chance(design_point.world, "circles of failed trials, and their best memoryless policies")
    replayer = Replayer(replace(design_point, task=replace(design_point.task, periods=len(total))))
    periods, trials = [], []
    examples: dict[str, tuple[Replay, int]] = {}
    for period in chosen.tolist():
        inside = replayer(period, ["paths"])
        if not np.array_equal(inside.steps, result.steps[period]):
            run_id = point.run.run_id if point.run else ""
            raise ConfigError(
                f"run {run_id}: its steps are not those that this version learns, so they cannot be looked into; "
                f"`rl-design-space store forget {run_id}` has its point learned anew by the next sweep"
            )
        best = best_memoryless(replayer.point, replayer.tables, inside.layout, inside.codes)
        of_period = [_of_trial(inside, trial, result.epsilon) for trial in np.flatnonzero(failed[period]).tolist()]
        periods.append(_of_period(inside, best, float(total[period]), of_period))
        trials += of_period
        of_kind = {row["ending"]: (inside, row["trial"]) for row in of_period}
        examples = {**of_kind, **examples}
    design = {
        "periods": len(total),
        "tail_periods": len(tail),
        "tail_share": float(total[tail].sum() / total.sum()),
        "failed_periods": float(failed.any(axis=1).mean()),
        "examined": len(chosen),
    }
    if not trials:
        return Examined(design, periods)
    ((most_frequent, _),) = Counter(row["ending"] for row in trials).most_common(1)
    return Examined(design, periods, trials, *examples[most_frequent])


def _of_trial(inside: Replay, trial: int, epsilon: Any) -> dict[str, Any]:
    end = ending(inside, trial)
    code = int(inside.codes.ravel()[np.flatnonzero(inside.row.ravel() == end.row)[0]])
    return {
        "period": inside.period,
        "trial": trial,
        "epsilon": float(epsilon[trial]),
        "reached": end.reached,
        "ending": end.kind,
        "circle": end.circle,
        "observations": end.observations,
        "observation": code,
        "observation_cells": int((inside.row == end.row).sum()),
        "observation_share": end.share,
        "stays": end.stays,
    }


def _of_period(inside: Replay, best: Memoryless, total_steps: float, failed: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "period": inside.period,
        "total_steps": total_steps,
        "optimum": inside.optimum,
        "trials": len(inside.steps),
        "failed_trials": len(failed),
        "memoryless_steps": np.nan if best.steps is None else best.steps,
        "memoryless_bound": best.bound,
        "verdict": verdict(best) if failed else "",
    }
