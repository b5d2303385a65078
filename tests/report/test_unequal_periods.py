"""Reports of points with unequal numbers of periods, as a precision gives them."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest

from rl_design_space.analysis.statistics import mean_estimate
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report import Best, Compare, Curves, Heatmap, Importance
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.tracker import StoredRun, enough_periods
from tests.points import planning
from tests.report.readers import LearningReader

SWEEP = [
    "task.periods=12", "task.trials=6", "world.size=4", "seed=0,1", "task.precision=0.2", "task.periods_at_most=60",
    "exploration=linear", "exploration.k=0.1,0.2", "representation=ad_hoc,distance",
]  # fmt: skip


@cache
def learned(point) -> LearningCurves:
    return simulate(point, threads=1)


class AskingReader(LearningReader):
    """A reader of points that ask for a precision."""

    def finished(self, fingerprints: Collection[str]) -> dict[str, StoredRun]:
        by_key = {planned.fingerprint: planned.point for planned in self.plan}
        return {
            key: StoredRun(key, enough=enough_periods(by_key[key].task, learned(by_key[key])))
            for key in fingerprints
            if key not in self.missing
        }

    def periods(self, run: StoredRun) -> dict[str, Any]:
        (planned,) = (planned for planned in self.plan if planned.fingerprint == run.run_id)
        curves = learned(planned.point)
        arrays = {name: getattr(curves, name) for name in ("steps", "success", "optimum", "rows")}
        return {**arrays, **curves.curves}


@pytest.fixture(scope="module")
def plan() -> Plan:
    with planning() as planner:
        return plan_overrides(SWEEP, planner)


@pytest.fixture(scope="module")
def runs(plan: Plan) -> Runs:
    return Runs.of_study(Study("mine", (), None, plan), AskingReader(plan))


def totals(plan: Plan, **wanted: object) -> list[np.ndarray]:
    """Return the total steps of the points with these values, an array for each seed."""
    chosen = [p for p in plan if all(p.parameters.get(name.replace("_", ".")) == wanted[name] for name in wanted)]
    return [learned(p.point).total_steps for p in sorted(chosen, key=lambda p: p.point.seed)]


def test_points_have_the_periods_that_were_enough(plan: Plan, runs: Runs):
    numbers = [len(learned(planned.point).steps) for planned in plan]
    assert len(set(numbers)) > 2
    assert [point.parameters["task.periods"] for point in runs.points] == numbers
    assert not any("task.precision" in point.parameters for point in runs.points)
    assert f" {min(numbers)} or " in runs.made_by
    (remark,) = runs.remarks
    assert remark.startswith("Precision reached by ")
    assert f" of 8 points, with {min(numbers)} to {max(numbers)} periods" in remark
    gap = Runs.of_study(Study("mine", (), None, plan), AskingReader(plan, missing={plan[0].fingerprint}))
    assert "task.precision" not in gap.points[0].parameters


def test_cells_and_lines_pool_all_periods_of_all_seeds(plan: Plan, runs: Runs):
    cells = Heatmap(rows="representation", cols="exploration.k").frames(runs)[MAIN]
    for cell in cells.to_dict("records"):
        seeds = totals(plan, representation=cell["representation"], exploration_k=cell["exploration.k"])
        assert len(seeds[0]) != len(seeds[1]) or cell["runs"] == 2
        assert (cell["value"], cell["low"], cell["high"]) == mean_estimate(np.concatenate(seeds))
    assert cells["in_best_set"].any()
    lines = Curves(by=["representation", "exploration.k"]).frames(runs)[MAIN]
    assert set(lines["runs"]) == {2}


def test_pairs_are_compared_by_the_periods_that_both_have(plan: Plan, runs: Runs):
    frame = Compare(a="exploration.k=0.1", b="exploration.k=0.2").frames(runs)[MAIN].set_index("pair")
    for name in ("ad_hoc", "distance"):
        sides = [totals(plan, representation=name, exploration_k=k) for k in (0.1, 0.2)]
        common = [min(len(one), len(other)) for one, other in zip(*sides, strict=True)]
        differences = np.concatenate([other[:n] - one[:n] for one, other, n in zip(*sides, common, strict=True)])
        row = frame.loc[f"representation={name}"]
        assert row["periods"] == sum(common)
        assert row["difference"] == pytest.approx(differences.mean())


def test_importance_and_best_accept_them(plan: Plan, runs: Runs):
    shares = Importance().frames(runs)[MAIN]
    assert {"representation", "exploration.k"} <= set(shares["effect"])
    best = Best().frames(runs)[MAIN].set_index(["representation", "exploration.k"])
    for name in ("ad_hoc", "distance"):
        values = np.concatenate(totals(plan, representation=name, exploration_k=0.1))
        assert best.loc[(name, 0.1), "value"] == pytest.approx(values.mean())


def test_the_longest_run_of_a_point_counts_in_figures_of_found_runs():
    rows = [
        {"run_id": f"{seed}{n}", "fingerprint": f"{seed}{n}", "artifacts": "", "seed": seed, "task.periods": n,
         "world.size": 4, "total_steps": 1.0 * n}
        for seed, n in ((0, 5), (0, 9), (1, 7), (0, 6))
    ]  # fmt: skip
    frame = pd.DataFrame(rows).set_index("run_id")
    runs = Runs.of_frame(frame, LearningReader(Plan([])), "the command")
    assert sorted(point.run.run_id for point in runs.points) == ["09", "17"]
    assert runs.remarks == ["Left out: 2 runs with fewer periods of the same points."]
    assert len({point.repetition.design for point in runs.points}) == 1
    every = Runs.of_frame(frame, LearningReader(Plan([])), "the command", every=True)
    assert (len(every.points), list(every.remarks)) == (4, [])
    assert len({point.repetition.design for point in every.points}) == 4
