"""Points of a study by their parameters, and their periods, each read once."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.config.compose import shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_overrides
from rl_design_space.report.runs import Runs
from tests.report.readers import LearningReader

SWEEP = ["task.periods=2", "task.trials=3", "exploration=linear", "world.size=4,5", "msa.lengths=[],[2],[2,3]"]


@pytest.fixture(scope="module")
def plan():
    with shipped_config():
        return plan_overrides(SWEEP, Planner())


def test_points_are_chosen_by_values(plan):
    runs = Runs.of_plan(plan, LearningReader(plan))
    assert [p.planned.name for p in runs.where({"world.size": 4, "msa.lengths": [2]})] == [
        "task.periods=2 task.trials=3 exploration=linear world.size=4 msa.lengths=[2]"
    ]
    assert len(runs.where({"world.size": [4, 5], "exploration": "linear"})) == 6
    assert len(runs.where({"msa.lengths": "[2, 3]"})) == 2
    assert runs.where({"world.size": 9}) == []


def test_one_point_is_found_or_refused(plan):
    runs = Runs.of_plan(plan, LearningReader(plan))
    assert runs.one({"world.size": 5, "msa.lengths": [2, 3]}).planned.point.world.size == 5
    with pytest.raises(ConfigError, match=r"world\.size=5: should be one point of sweep, not 3"):
        runs.one({"world.size": 5})
    with pytest.raises(ConfigError, match=r"world\.siz: .*did you mean world\.size\?"):
        runs.where({"world.siz": 5})


def test_periods_are_what_was_learned_and_read_once(plan, monkeypatch: pytest.MonkeyPatch):
    reader = LearningReader(plan, missing={plan[1].fingerprint})
    runs = Runs.of_plan(plan, reader)
    assert [point.planned for point in runs.points if point not in runs.recorded] == [plan[1]]
    assert runs.result(runs.points[1]) is None
    first, expected = runs.result(runs.points[0]), simulate(plan[0].point)
    assert np.array_equal(first.steps, expected.steps)
    assert np.array_equal(first.total_steps, expected.total_steps)
    assert np.array_equal(first.over_optimum, expected.over_optimum)
    assert first.point is plan[0].point
    monkeypatch.setattr(reader, "periods", None)
    assert runs.result(runs.points[0]) is first


def test_a_run_that_kept_its_curves_alone_is_refused_by_name(plan, monkeypatch: pytest.MonkeyPatch):
    reader = LearningReader(plan)
    monkeypatch.setattr(reader, "periods", lambda run: {"steps/mean": np.zeros(3)})
    runs = Runs.of_plan(plan, reader)
    assert runs.kept(runs.points[0]) is None
    with pytest.raises(ConfigError, match=r"tracking\.artifact=curves: the run of `rl-design-space task\.periods=2"):
        runs.result(runs.points[0])
