"""Pictures of learning curves mark where stages begin, and draw the baselines of each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.learning import simulate
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report.curves import Curves
from rl_design_space.report.curves_figure import CurvesFigure
from rl_design_space.report.runs import Runs
from rl_design_space.report.scratch import SCRATCH
from rl_design_space.report.stage_marks import GREY, STAGES
from tests.points import planning
from tests.report.readers import LearningReader


@pytest.fixture(scope="module")
def both() -> Study:
    """The same stages with and without carried values."""
    with planning() as planner:
        sweep = [*SWEEP, "curriculum.trials=3", "task.goals=2", "curriculum.carry=same_place,none"]
        return Study("mine", (), planner.composer.config(()), plan_overrides(sweep, planner))


SWEEP = ["task.periods=4", "task.trials=6", "world.size=4", "curriculum=coarse_to_fine", "curriculum.sizes=[2]"]
FIGURE = CurvesFigure(
    title="Stages",
    shows="One line",
    panels=[{"title": "all", "where": {}, "lines": {"coarse to fine": {"curriculum": "coarse_to_fine"}}}],
)


def test_a_line_marks_where_a_stage_begins_and_each_has_its_levels():
    with planning() as planner:
        config = planner.composer.config(())
        study = Study("mine", (), config, plan_overrides([*SWEEP, "curriculum.trials=3", "task.goals=2"], planner))
    frames = FIGURE.frames(Runs.of_study(study, LearningReader(study.plan)))
    found = frames[STAGES]
    assert found[["begin", "end"]].values.tolist() == [[0, 3], [3, 9]]
    curves = simulate(study.plan[0].point)
    assert found["optimum"].tolist() == [stage.optimum.mean() for stage in curves.stages]
    assert (found["random_walk"] > found["optimum"]).all()
    above, below = FIGURE.draw(frames).axes
    for axis in (above, below):
        assert [line.get_xdata()[0] for line in axis.lines if line.get_gid() == STAGES] == pytest.approx([2.5])
    assert len(above.collections) >= 2 * len(found)
    assert not np.isnan(found.to_numpy()[:, 1:].astype(float)).any()
    assert frames[SCRATCH].empty
    assert "Learning the stages from scratch is not recorded" in FIGURE.text(frames)[-1]


def test_learning_from_scratch_is_drawn_beside_stages_wherever_it_is_recorded(both: Study):
    figure = replace(FIGURE, panels=[{**FIGURE.panels[0], "lines": {"carried": {"curriculum.carry": "same_place"}}}])
    frames = figure.frames(Runs.of_study(both, LearningReader(both.plan)))
    carried, scratch = (simulate(planned.point) for planned in both.plan)
    found = frames[SCRATCH]
    assert found["mean"].tolist() == scratch.steps.mean(axis=0).tolist()
    assert found["ratio"].unique().tolist() == pytest.approx([carried.total_steps.mean() / scratch.total_steps.mean()])
    assert f"carried (all) {found['ratio'][0]:.2f}" in figure.text(frames)[-1]
    above, _ = figure.draw(frames).axes
    (line,) = [line for line in above.lines if line.get_gid() == SCRATCH]
    assert line.get_ydata().tolist() == found["mean"].tolist()
    assert [text.get_text() for text in above.get_legend().get_texts()] == ["carried", "from scratch"]


def test_a_line_from_scratch_is_its_own_baseline(both: Study):
    figure = replace(FIGURE, panels=[{**FIGURE.panels[0], "lines": {"scratch": {"curriculum.carry": "none"}}}])
    assert figure.frames(Runs.of_study(both, LearningReader(both.plan)))[SCRATCH].empty


def test_curves_of_any_runs_mark_where_their_stages_begin(both: Study):
    with planning() as planner:
        plain = plan_overrides([*SWEEP[:3], "task.trials=9", "task.goals=2"], planner)
    study = replace(both, plan=Plan((*both.plan, *plain)))
    report = Curves(by=("curriculum.carry",))
    frames = report.frames(Runs.of_study(both, LearningReader(both.plan)))
    assert frames[STAGES].values.tolist() == [["curriculum.carry=same_place", 3], ["curriculum.carry=none", 3]]
    axis = report.draw(frames).axes[0]
    assert [line.get_xdata()[0] for line in axis.lines if line.get_gid() == STAGES] == [2.5]
    some = report.frames(Runs.of_study(study, LearningReader(study.plan)))
    (mark,) = [line for line in report.draw(some).axes[0].lines if line.get_gid() == STAGES]
    assert mark.get_color() != GREY  # one of three lines has no stages
    assert list(report.csv(some)) == [""]
