"""Reports of points with several seeds, and of several points where one is meant."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from rl_design_space.analysis.quality import quality
from rl_design_space.analysis.statistics import mean_estimate
from rl_design_space.errors import ConfigError
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study, plan_overrides, union
from rl_design_space.report import (
    ClaimsLedger,
    Compare,
    Curves,
    CurvesFigure,
    Heatmap,
    PublishedTable,
    QualityMap,
    Sensitivity,
)
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from tests.points import planning
from tests.report.readers import LearningReader

SIZE = ["task.periods=4", "task.trials=6", "world.size=4", "seed=0,1,2"]
K = (0.02, 0.1)
ARRAYS = ("steps", "success", "optimum", "rows")


@cache
def learned(point) -> LearningCurves:
    return simulate(point, threads=1)


@pytest.fixture(scope="module")
def plan() -> Plan:
    with planning() as planner:
        linear = plan_overrides([*SIZE, "exploration=linear", "exploration.k=0.02,0.1"], planner)
        return union([linear, plan_overrides(SIZE, planner)])


@pytest.fixture(scope="module")
def runs(plan: Plan) -> Runs:
    study = Study("mine", (), None, plan)  # the config matters to reports of files only
    return Runs.of_study(study, LearningReader(plan))


def totals(plan: Plan, **wanted: object) -> np.ndarray:
    """Return total steps of the points with these values, seed by seed."""
    chosen = [p for p in plan if all(p.parameters.get(name.replace("_", ".")) == wanted[name] for name in wanted)]
    return np.concatenate([learned(p.point).total_steps for p in sorted(chosen, key=lambda p: p.point.seed)])


def test_every_figure_pools_the_periods_of_all_seeds(plan: Plan, runs: Runs):
    expected = [mean_estimate(totals(plan, exploration_k=k)) for k in K]
    assert len(totals(plan, exploration_k=0.02)) == 12
    cells = Heatmap(rows="exploration.k", cols="exploration").frames(runs)[MAIN].dropna(subset="exploration.k")
    line = Sensitivity(parameter="exploration.k").frames(runs)[MAIN]
    for frame in (cells[cells["exploration"] == "linear"], line):
        assert frame["runs"].tolist() == [3, 3]
        assert list(zip(frame["value"], frame["low"], frame["high"], strict=True)) == expected
    steps = np.concatenate([learned(p.point).steps for p in plan if p.parameters.get("exploration.k") == 0.02])
    for curve, of in (("steps/mean", np.mean), ("steps/median", np.median)):
        lines = Curves(by="exploration.k", curve=curve).frames(runs)[MAIN].set_index("line")
        assert lines.loc["exploration.k=0.02", "mean"].tolist() == pytest.approx(of(steps, axis=0).tolist())


def test_a_comparison_pools_the_differences_of_all_seeds(plan: Plan, runs: Runs):
    frame = Compare(a="exploration=linear exploration.k=0.02", b="exploration=constant").frames(runs)[MAIN]
    (row,) = frame.to_dict("records")
    differences = totals(plan, exploration="constant") - totals(plan, exploration_k=0.02)
    assert (row["difference"], row["low"], row["high"]) == pytest.approx(mean_estimate(differences))
    assert row["b"] - row["a"] == pytest.approx(row["difference"])
    assert row["periods"] == 12


def test_several_runs_a_side_are_refused_by_name_or_averaged(plan: Plan, runs: Runs):
    with pytest.raises(ConfigError, match=r"exploration\.k: 2 runs of one side \(exploration=linear\) differ"):
        Compare(a="exploration=linear", b="exploration=constant").frames(runs)
    (row,) = Compare(a="exploration=constant", b="exploration=linear", mean=True).frames(runs)[MAIN].to_dict("records")
    both = np.mean([totals(plan, exploration_k=k) for k in K], axis=0)
    differences = both - totals(plan, exploration="constant")
    assert (row["difference"], row["low"], row["high"]) == pytest.approx(mean_estimate(differences))


def test_runs_without_common_periods_are_not_paired(runs: Runs, plan: Plan):
    unequal = Runs(runs.points[:-1], LearningReader(plan))  # without the last seed of the constant schedule
    (row,) = Compare(a="exploration.k=0.02", b="exploration.k=0.1").frames(unequal)[MAIN].to_dict("records")
    assert row["periods"] == 12
    assert Compare(a="exploration=linear exploration.k=0.02", b="exploration=constant").frames(unequal)[MAIN][
        "periods"
    ].tolist() == [8]
    gap = Runs([p for p in runs.points if p.key(("exploration.k", "seed")) != (0.1, 2)], LearningReader(plan))
    with pytest.raises(ConfigError, match="seed: not all runs that are averaged have the same seeds"):
        Compare(a="exploration=constant", b="exploration=linear", mean=True).frames(gap)


def test_a_seed_is_not_a_schedule_to_choose_from(plan: Plan, runs: Runs):
    table = QualityMap(
        title="-", gradings={}, labels={}, rows={"all": {"exploration": "linear"}},
    )  # fmt: skip
    found = table.measured(runs)["all"]["exploration"]
    pools = {}
    for k in K:
        seeds = [learned(p.point) for p in plan if p.parameters.get("exploration.k") == k]
        pools[f"k = {k}"] = LearningCurves(
            *(
                np.concatenate([getattr(each, name) for each in seeds])
                for name in ("steps", "success", "optimum", "rows")
            ),
            seeds[0].epsilon,
        )
    assert quality(pools).best in found.text
    assert "seed" not in found.text


def test_a_table_and_a_figure_pool_seeds_and_refuse_other_points(plan: Plan, runs: Runs):
    table = PublishedTable(
        title="-", value="total_steps", panel={"k": "exploration.k"}, row={"d": "world.size"},
        column={"n": "task.goals"}, labels={}, published={0.02: {4: {3: 100}}},
    )  # fmt: skip
    (cell,) = table.frames(runs)[MAIN].to_dict("records")
    assert (cell["measured"], cell["ci_low"], cell["ci_high"]) == mean_estimate(totals(plan, exploration_k=0.02))
    with pytest.raises(ConfigError, match=r"exploration\.k: several values for one cell"):
        PublishedTable(
            title="-", value="total_steps", panel={"r": "representation"}, row={"d": "world.size"},
            column={"n": "task.goals"}, labels={}, published={"ad_hoc": {4: {3: 100}}},
        ).frames(runs)  # fmt: skip
    panel = {"title": "p", "where": {"exploration": "linear"}, "lines": {"steep": {"exploration.k": 0.1}}}
    frame = CurvesFigure(title="-", shows="-", panels=[panel]).frames(runs)[MAIN]
    steps = np.concatenate([learned(p.point).steps for p in plan if p.parameters.get("exploration.k") == 0.1])
    assert frame["mean"].tolist() == pytest.approx(steps.mean(axis=0).tolist())
    with pytest.raises(ConfigError, match=r"not 6; they differ in exploration\.k$"):
        CurvesFigure(title="-", shows="-", panels=[{**panel, "lines": {"any": {"world.size": 4}}}]).frames(runs)


def test_claims_are_judged_on_the_periods_of_all_seeds(plan: Plan, runs: Runs):
    parts = "rl_design_space.analysis.parts"
    level = {"_target_": f"{parts}.Level", "what": "level", "measure": "total_steps", "point": {"exploration.k": 0.02}}
    best = {
        "_target_": f"{parts}.ExpectedOverBest", "what": "best", "measure": "total_steps", "parameter": "exploration.k",
        "among": {"exploration": "linear"}, "expected": 0.02,
    }  # fmt: skip
    claim = {"statement": "-", "study": "mine", "parts": [level, best]}
    (judged,) = ClaimsLedger(title="-", common={}, claims={"a": claim}).judged(runs)
    measured, ratio = judged.finding.parts
    assert measured.value == pytest.approx(totals(plan, exploration_k=0.02).mean())
    odd = [totals(plan, exploration_k=k)[1::2].mean() for k in K]
    assert ratio.value == pytest.approx(odd[0] / min(odd))
