"""Points of several stages from configs to recorded runs and back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from rl_design_space.config import user_config
from rl_design_space.config.recorded import recorded_point
from rl_design_space.design import CoarseToFine, Constant, Direction, NewGoals, Stage, Stages
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves
from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import plan_point
from rl_design_space.tracking.content import content_of
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.load import load_runs
from rl_design_space.tracking.record import params, point_record, result_of
from rl_design_space.tracking.run_files import check_config
from tests.points import planned_point
from tests.tracking.stores import learned, tracker_at
from tests.tracking.stores import record as record_point

SMALL = ("world.size=4", "task.goals=2", "task.trials=6")
#: The stages of a curriculum of the user's own, with options by name, and a function that carries.
MINE = """\
# Three stages.
_target_: rl_design_space.design.Stages
stages:
  - {world.size: 3, task.trials: 5}
  - {world.size: 6, task.trials: 5, layout: scaled, carry: staged_rules.same_state}
  - {task.trials: 2, layout: new, carry: none, representation: direction, learner.alpha: 0,
     exploration: constant, exploration.epsilon: 0}
"""
RULES = """\
import numpy as np
def same_state(before, after):
    states = np.arange(after.codes[0].size) % before.codes[0].size
    return np.broadcast_to(states.reshape(after.codes.shape[1:]), after.codes.shape)
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A config folder with a curriculum, beside a module with its carry rule."""
    (tmp_path / "conf" / "curriculum").mkdir(parents=True)
    (tmp_path / "conf" / "curriculum" / "mine.yaml").write_text(MINE, encoding="utf-8")
    (tmp_path / "staged_rules.py").write_text(RULES, encoding="utf-8")
    return tmp_path / "conf"


def test_a_curriculum_of_the_users_own_is_learned_recorded_and_built_again(folder: Path):
    with user_config.used(folder):
        planned = plan_point(["curriculum=mine", "world.size=3", "task.goals=2", "task.periods=3"])
        _, carrying, used = planned.point.curriculum.stage_list()
        assert carrying.carry.__name__ == "same_state"
        assert dict(used.changes) == {
            "exploration": Constant(epsilon=0.0), "learner.alpha": 0, "representation": Direction(), "task.trials": 2,
        }  # fmt: skip
        assert planned.parameters["curriculum.stages.2.carry.source"].startswith("sha256:")
        assert "carry: staged_rules.same_state" in params(planned.parameters)["curriculum.stages"]
        config = yaml.safe_load(yaml.safe_dump(resolved_config(planned.point), sort_keys=False))
        assert recorded_point(config, "run abc") == planned.point
        check_config(FoundRun("abc", "", 0, 0, "", params(planned.parameters), {}), config)
    with pytest.raises(ConfigError, match=r"carry=staged_rules\.same_state: comes from the store"):
        recorded_point(config, "run abc")


def test_the_run_of_a_staged_point_holds_scalars_and_a_curve_of_its_stages(shared_database: Path):
    planned, curves = learned(*SMALL, "curriculum=new_goals", "curriculum.layouts=2")
    plain, plain_curves = learned(*SMALL)
    tracker = tracker_at(shared_database, experiment="staged")
    for point, result in ((planned, curves), (plain, plain_curves)):
        record_point(tracker, point, result)
    runs = load_runs(uri=f"sqlite:///{shared_database}", experiment="staged").set_index("curriculum")
    assert runs.loc["new_goals", "stage2/total_steps"] == curves.steps[:, 6:].sum(axis=1).mean()
    assert runs.loc["new_goals", "curriculum.layouts"] == 2
    assert np.isnan(runs.loc["none", "stage2/total_steps"])


def test_curves_run_on_and_the_file_of_a_result_holds_its_stages():
    planned, curves = learned(*SMALL, "curriculum=coarse_to_fine", "curriculum.sizes=[2]", "curriculum.trials=3")
    record = point_record(planned, curves, {})
    content = content_of(record, "a")
    assert [value for name, value, _ in content.metrics if name == "stage"] == [1.0] * 3 + [2.0] * 6
    assert len([name for name, _, _ in content.metrics if name == "steps/mean"]) == 9
    again: LearningCurves = result_of(record)
    assert {**again.scalars()} == {**curves.scalars()}
    alone = again.stage(2)
    np.testing.assert_array_equal(alone.steps, curves.steps[:, 3:])
    np.testing.assert_array_equal(again.over_optimum[:, 3:], alone.over_optimum)
    np.testing.assert_array_equal(again.over_optimum[:, :3], again.stage(1).over_optimum)
    # In steps of equal length: a step on 2×2 is twice as long as one on 4×4.
    assert again.scaled_steps.tolist() == (5 * again.steps[:, :3].sum(axis=1) + 2.5 * alone.total_steps).tolist()
    frame = again.to_frame(periods=True)
    assert frame.groupby("stage")["optimum"].mean().tolist() == [s.optimum.mean() for s in again.stages]
    with pytest.raises(LookupError, match="stage 3: this result has 2 stages"):
        again.stage(3)


def test_points_without_stages_have_the_params_that_they_had():
    for overrides in ((), ("curriculum=new_goals", "curriculum.layouts=1")):
        planned = planned_point(overrides)
        assert not [name for name in params(planned.parameters) if "curriculum" in name]
        assert "curriculum" not in resolved_config(planned.point)


def test_a_sweep_over_curricula_counts_the_points_without():
    plan = Plan([planned_point(["curriculum=zero_shot"]), planned_point()])
    assert plan.axes == {"curriculum": {"zero_shot": 1, "none": 1}}


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("curriculum.stages=[{world.sise: 3}]", "stage 1: world.sise: no such key; did you mean world.size?"),
        ("curriculum.stages=[{},{world.size: 20}]", "stage 2: layout=same: places on 10×10 are not places on 20×20"),
        ("curriculum.stages=[{representation: directon}]", "stage 1: representation=directon: no such option; did you"),
        ("curriculum.stages=[{},{carry: no.such}]", "stage 2: carry=no.such: cannot be imported"),
        ("curriculum.stages=[{task.periods: 3}]", "task.periods: all stages of a period share it"),
        ("curriculum.stages=[{},{representation: direction}]", "carry=same_observation: observations of another"),
        ("curriculum.stages=[{},{msa: length_3}]", "the Q-matrix is that of other actions"),
        (
            "curriculum.stages=[{},{refine: {splt: all}}]",
            "refine={splt: all}: splt: no such key; did you",
        ),
        ("curriculum.stages=[{},{msa.lengths: 3}]", "stage 2: msa.lengths=3: should be a list"),
        ("curriculum.stages=[{world: {size: 10}}]", "stage 1: world={size: 10}: should be world.size: 10"),
        ("curriculum.stages=[{task: {trials: 3}}]", "stage 1: task={trials: 3}: should be task.trials: 3"),
        ("curriculum.stages=[{world: 3}]", "stage 1: world=3: should be the name of an option"),
        ("curriculum.stages=[{},3]", "stage 2=3: should map keys to values, as {world.size: 5, task.trials: 20} does"),
        ("curriculum.stages=[{refine: 3}]", "stage 1: refine=3: should be disagreeing, all, none, or a mapping such"),
        ("curriculum.stages=[{layout: old}]", "stage 1: layout=old: should be 'same', 'scaled', 'new' or 'shifted'"),
    ],
)
def test_a_stage_that_cannot_be_used_is_refused_with_its_number(override: str, message: str):
    with pytest.raises(ConfigError) as caught:
        planned_point([override])
    assert message in str(caught.value)


def test_an_option_without_a_stage_is_refused(folder: Path):
    file = folder / "curriculum" / "mine.yaml"
    file.write_text("_target_: rl_design_space.design.Stages\nstages: []\n", encoding="utf-8")
    expected = r"curriculum.stages=\[\]: curriculum=mine should list a stage, .* without stages, use curriculum=none"
    for plan in (plan_point, planned_point):  # composed, and assembled
        with user_config.used(folder), pytest.raises(ConfigError, match=expected):
            plan(["curriculum=mine"])
    assert planned_point(["curriculum=none", "curriculum.stages=[]"]).point == planned_point().point
    recorded_point({**resolved_config(planned_point().point), "curriculum": yaml.safe_load(file.read_text())}, "old")


def test_coarse_grids_without_a_size_are_refused():
    expected = r"curriculum.sizes=\[\]: should list .* as in \[5\]; without smaller grids, use curriculum=none"
    for plan in (plan_point, planned_point):
        with pytest.raises(ConfigError, match=expected):
            plan(["curriculum=coarse_to_fine", "curriculum.sizes=[]"])


def test_stages_are_one_value_however_they_are_written():
    written = planned_point(["curriculum.stages=[{exploration.epsilon: 0, exploration: constant},{layout: new}]"])
    assert written.point.curriculum == Stages(
        stages=(Stage(changes={"exploration": Constant(epsilon=0.0)}), Stage(layout="new"))
    )
    assert CoarseToFine(sizes=[3, [4, 5]]) == CoarseToFine(sizes=(3, (4, 5)))
    assert NewGoals(layouts=3).stage_list()[1:] == (Stage(layout="new"),) * 2
