"""Points of a study by their parameters, and their periods, each read once."""

from __future__ import annotations

from dataclasses import replace
from threading import Barrier
from typing import Any

import numpy as np
import pandas as pd
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report.points import Point, frame_with_defaults, with_defaults
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.tracker import StoredRun
from tests.points import planning
from tests.report.readers import LearningReader

SWEEP = ["task.periods=2", "task.trials=3", "exploration=linear", "world.size=4,5", "msa.lengths=[],[2],[2,3]"]


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        return Study("mine", (), planner.composer.config(()), plan_overrides(SWEEP, planner))


def test_points_are_chosen_by_values(study: Study):
    runs = Runs.of_study(study, LearningReader(study.plan))
    assert [p.planned.name for p in runs.where({"world.size": 4, "msa.lengths": [2]})] == [
        "task.periods=2 task.trials=3 exploration=linear world.size=4 msa.lengths=[2]"
    ]
    assert len(runs.where({"world.size": [4, 5], "exploration": "linear"})) == 6
    assert len(runs.where({"msa.lengths": "[2, 3]"})) == 2
    assert runs.where({"world.size": 9}) == []


def test_defaults_that_points_leave_out_are_values_of_those_that_have_such_a_field():
    coarse, none = Point({"curriculum": "coarse_to_fine"}, None), Point({"curriculum": "none"}, None)
    used = Point({"curriculum": "new_goals", "curriculum.zero_shot": 5}, None)
    found = with_defaults([coarse, used, none])
    assert [point.key(["curriculum.zero_shot"]) for point in found] == [(0,), (5,), (None,)]
    assert found[0].has({"curriculum.zero_shot": 0})
    assert with_defaults([coarse]) == [coarse]  # nobody lists it
    (asked,) = with_defaults([coarse], ["--given", "curriculum.zero_shot=0"])
    assert asked.parameters == {**coarse.parameters, "curriculum.zero_shot": 0}


def test_a_frame_has_them_too():
    rows = [
        {"curriculum": "coarse_to_fine"},
        {"curriculum": "new_goals", "curriculum.zero_shot": 5.0},
        {"curriculum": "none"},
        {"curriculum": "coarse_to_fine", "curriculum.source": "version 1"},
    ]
    found = frame_with_defaults(pd.DataFrame(rows))["curriculum.zero_shot"]
    assert found.tolist()[:2] == [0, 5]
    assert found.isna().tolist() == [False, False, True, True]
    plain = pd.DataFrame([{"reward": "many_rewards", "seed": 1}])
    assert frame_with_defaults(plain).equals(plain)


def test_one_point_is_found_or_refused(study: Study):
    runs = Runs.of_study(study, LearningReader(study.plan))
    assert runs.one({"world.size": 5, "msa.lengths": [2, 3]}).planned.point.world.size == 5
    with pytest.raises(ConfigError, match=r"world\.size=5: should be one point of sweep, not 3"):
        runs.one({"world.size": 5})
    with pytest.raises(ConfigError, match=r"world\.siz: .*did you mean world\.size\?"):
        runs.where({"world.siz": 5})


def test_periods_are_what_was_learned_and_read_once(study: Study, monkeypatch: pytest.MonkeyPatch):
    reader = LearningReader(study.plan, missing={study.plan[1].fingerprint})
    runs = Runs.of_study(study, reader)
    assert [point.planned for point in runs.points if point not in runs.recorded] == [study.plan[1]]
    assert runs.result(runs.points[1]) is None
    first, expected = runs.result(runs.points[0]), simulate(study.plan[0].point)
    assert np.array_equal(first.steps, expected.steps)
    assert np.array_equal(first.total_steps, expected.total_steps)
    assert np.array_equal(first.over_optimum, expected.over_optimum)
    assert first.point is study.plan[0].point
    monkeypatch.setattr(reader, "periods", None)
    assert runs.result(runs.points[0]) is first
    runs.forget(runs.points[0])
    assert np.array_equal(runs.curve(runs.points[0], "epsilon"), expected.epsilon)  # curves stay


def test_a_run_that_kept_its_curves_alone_is_refused_by_name(study: Study, monkeypatch: pytest.MonkeyPatch):
    reader = LearningReader(study.plan)
    monkeypatch.setattr(reader, "periods", lambda run: {"steps/mean": np.zeros(3)})
    runs = Runs.of_study(study, reader)
    assert runs.kept(runs.points[0]) is None
    with pytest.raises(ConfigError, match=r"tracking\.artifact=curves: the run of `rl-design-space task\.periods=2"):
        runs.result(runs.points[0])


def test_a_reading_leaves_out_the_points_that_have_another_value_and_no_others():
    small = ["task.periods=2", "task.trials=3", "world.size=4"]
    with planning() as planner:
        representations = plan_overrides([*small, "representation=ad_hoc,direction,distance"], planner)
        observes_all = plan_overrides([*small, "representation=direction", "representation.goals=all"], planner)
        plan = replace(representations, points=[*representations, *observes_all])
        study = Study("mine", (), planner.composer.config(()), plan)
    runs = Runs.of_study(study, LearningReader(study.plan))
    under = runs.under({"representation.goals": "all"})
    assert [point.parameters["representation"] for point in under.points] == ["ad_hoc", "direction"]
    assert len(runs.points) == 4
    assert under.result(under.points[0]) is runs.result(runs.points[0])
    with pytest.raises(ConfigError, match=r"did you mean representation\.goals"):
        runs.under({"representation.goal": "all"})


class ServerReader(LearningReader):
    """A reader whose runs are read six at a time, or not at all."""

    in_flight = 6
    together = Barrier(in_flight)

    def periods(self, run: StoredRun) -> dict[str, Any]:
        self.together.wait(timeout=10)
        return super().periods(run)


def test_as_many_runs_are_read_at_the_same_time_as_the_reader_says(study: Study):
    runs = Runs.of_study(study, ServerReader(study.plan))
    assert runs.estimate(runs.points, "total_steps").value > 0
