"""Pictures of learning curves mark where stages begin, and draw the baselines of each."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report.curves_figure import CurvesFigure
from rl_design_space.report.runs import Runs
from rl_design_space.report.stage_marks import STAGES
from tests.points import planning
from tests.report.readers import LearningReader

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
