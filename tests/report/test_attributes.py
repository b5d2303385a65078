"""What leaving attributes out costs: the numbers of the study `attributes`, with few periods."""

from __future__ import annotations

import pytest

from rl_design_space.config.compose import shipped_config
from rl_design_space.design import Direction, Without
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, load_study
from rl_design_space.report.attributes import ALWAYS
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from tests.report.readers import LearningReader


@pytest.fixture(scope="module")
def study() -> Study:
    with shipped_config():
        return load_study("attributes", ["task.periods=6", "task.trials=12", "task.max_steps=200"])


def test_the_cost_is_the_ratio_to_the_whole_observation(study: Study):
    with shipped_config():
        report = study.report()
    frames = report.frames(Runs.of_study(study, LearningReader(study.plan)))
    main = frames[MAIN].set_index(["representation", "left_out", "stage"])
    points = {planned.point.representation: planned.point for planned in study.plan}
    whole = simulate(points[Without()]).total_steps.mean()
    without = simulate(points[Without(leave_out=("goal2",), counters=(1,))]).total_steps.mean()
    assert main.loc[("Direction", "goal2", "1"), "ratio"] == pytest.approx(without / whole)
    due = simulate(points[Direction(goals="due")]).total_steps.mean()
    assert main.loc[("Direction", "goals=due", ALWAYS), "ratio"] == pytest.approx(due / whole)
    # Goals that are reached are not observed anyway.
    assert main.loc[("Direction", "goal1", "1"), "ratio"] == 1
    assert sorted(main.loc["AdHoc"].index.get_level_values("left_out").unique()) == ["counter", "x", "y"]
    table, _, verdicts = report.text(frames)
    assert "counter 2" in table
    assert verdicts.count("\n") == 2


def test_a_reference_is_needed(study: Study):
    with shipped_config():
        report = study.report()
    runs = Runs.of_study(study, LearningReader(study.plan))
    less = [point for point in runs.points if point.parameters.get("representation.leave_out") != "[]"]
    with pytest.raises(ConfigError, match="no run has the whole observation"):
        report.frames(runs.only(less))
