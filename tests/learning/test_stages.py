"""Periods of several stages: agreement with the reference, and what stages leave as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from rl_design_space.design import (
    AdHoc,
    CoarseToFine,
    Constant,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    Linear,
    MultiStepActions,
    NewGoals,
    Stage,
    Stages,
    Task,
    Torus,
    Walled,
    ZeroShot,
    from_scratch,
    stages_of,
)
from rl_design_space.environment import OrderedGoals
from rl_design_space.errors import ConfigError
from rl_design_space.learning import LearningCurves, simulate, stage_learning, stages
from rl_design_space.learning.stage_layouts import stage_layouts
from rl_design_space.plan.fingerprint import fingerprint
from tests import reference_stages
from tests.learning import strategies

TASK = Task(goals=2, trials=12, periods=3, max_steps=300)
POINT = DesignPoint(seed=5, task=Task(goals=2, trials=12, periods=30), world=Torus(size=6))
AS_IT_IS = {"learner.alpha": 0, "exploration": Constant(epsilon=0.0)}


def assert_agrees(point: DesignPoint) -> None:
    """Compare steps, success and rows of all stages with those of the reference, bit for bit."""
    curves = simulate(point, threads=1)
    expected = [reference_stages.learn_period(point, period) for period in range(point.task.periods)]
    steps = [[step for stage in period for step in stage.played.steps] for period in expected]
    success = [[solved for stage in period for solved in stage.played.success] for period in expected]
    np.testing.assert_array_equal(curves.steps, steps)
    np.testing.assert_array_equal(curves.success, success)
    for number, stage in enumerate(curves.stages):
        rows = [(len(period[number].played.q), period[number].changed) for period in expected]
        np.testing.assert_array_equal(stage.rows, rows)
        np.testing.assert_array_equal(stage.carried, [period[number].carried for period in expected])


@settings(deadline=None, max_examples=30)
@given(point=strategies.staged_points().filter(stages_of))
def test_steps_success_and_rows_of_all_stages_agree_with_the_reference(point: DesignPoint):
    for number, layouts in enumerate(stage_layouts(point, stages_of(point))):
        expected = [reference_stages.layouts_of(point, period)[number] for period in range(point.task.periods)]
        assert layouts.tolist() == expected
    assert_agrees(point)


@pytest.mark.parametrize(
    "curriculum",
    [
        CoarseToFine(sizes=(2, 3, (3, 4)), trials=5),
        NewGoals(layouts=4),
        NewGoals(layouts=3, layout="shifted"),
        ZeroShot(size=3, layout="scaled"),
        # Back to the observations of the first stage, some of which do not occur in the second one.
        Stages(stages=(Stage(), Stage.of({"world.size": 3, "layout": "scaled"}), Stage(layout="scaled"))),
    ],
    ids=lambda curriculum: type(curriculum).__name__,
)
@pytest.mark.parametrize("representation", [AdHoc(), Distance(), Direction(goals="all"), Direct()], ids=str)
def test_pinned_curricula_agree(representation, curriculum):
    assert_agrees(replace(POINT, representation=representation, curriculum=curriculum, task=TASK))


@pytest.mark.parametrize("carry", ["same_observation", "same_place"])
@pytest.mark.parametrize("representation", [AdHoc(), Distance(), Direction(), Direct()], ids=lambda r: type(r).__name__)
@pytest.mark.parametrize("msa", [MultiStepActions(), MultiStepActions(lengths=(3,))], ids=["primitive", "msa"])
def test_carrying_to_the_identical_world_is_going_on(carry, representation, msa):
    point = replace(POINT, representation=representation, msa=msa)
    halves = Stages(stages=(Stage.of({"task.trials": 5}), Stage.of({"task.trials": 7, "carry": carry})))
    whole, parts = simulate(point), simulate(replace(point, curriculum=halves))
    np.testing.assert_array_equal(parts.steps, whole.steps)
    np.testing.assert_array_equal(parts.success, whole.success)
    np.testing.assert_array_equal(parts.stages[1].carried, whole.rows[:, 0])


def test_the_first_stage_is_the_point_alone():
    alone, staged = simulate(POINT), simulate(replace(POINT, curriculum=ZeroShot()))
    np.testing.assert_array_equal(staged.steps[:, : POINT.task.trials], alone.steps)
    np.testing.assert_array_equal(staged.stages[0].rows, alone.rows)


def test_a_stage_that_carries_nothing_is_learning_from_scratch_with_other_random_numbers():
    twice = simulate(replace(POINT, curriculum=Stages(stages=(Stage(), Stage(carry="none")))))
    assert not np.array_equal(twice.steps[:, :12], twice.steps[:, 12:])
    np.testing.assert_array_equal(twice.stages[1].optimum, twice.stages[0].optimum)
    assert not twice.stages[1].carried.any()


def test_a_stage_without_learning_changes_nothing_and_repeats_itself():
    used = Stage.of({**AS_IT_IS, "learner.ties": "first", "task.trials": 9})
    curves = simulate(replace(POINT, curriculum=Stages(stages=(Stage(), used, used))))
    for stage in curves.stages[1:]:
        np.testing.assert_array_equal(stage.rows[:, 1], 0)
    trials = curves.steps[:, 12:]
    assert (trials == trials[:, :1]).all()
    going_on = simulate(replace(POINT, curriculum=Stages(stages=(Stage(), used, Stage.of({"task.trials": 5})))))
    # Only ties are drawn again: where values differ, so that there are none, every trial takes the same way.
    assert going_on.stages[2].carried.tolist() == curves.stages[0].rows[:, 0].tolist()


def test_each_grid_or_layout_may_be_used_as_it_is_before_it_is_learned():
    goals = stages_of(replace(POINT, curriculum=NewGoals(layouts=3, zero_shot=2, epsilon=0.3)))
    assert [stage.layout for stage in goals] == ["same", "new", "same", "new", "same"]
    assert [stage.point.learner.alpha for stage in goals] == [0.1, 0, 0.1, 0, 0.1]
    assert [stage.point.task.trials for stage in goals[1:3]] == [2, POINT.task.trials]
    assert [stage.point.exploration for stage in goals[:3]] == [
        POINT.exploration,
        Constant(epsilon=0),
        Constant(epsilon=0.3),
    ]
    grids = stages_of(replace(POINT, curriculum=CoarseToFine(sizes=(2, 3), zero_shot=2)))
    assert [stage.point.world.size for stage in grids] == [2, 3, 3, POINT.world.size, POINT.world.size]
    assert {stage.layout for stage in grids} == {"scaled"}
    used = simulate(replace(POINT, curriculum=CoarseToFine(sizes=(3,), zero_shot=2)))
    # What is used as it is changes nothing, so learning goes on with what was carried to it.
    assert used.stages[2].carried.tolist() == used.stages[2].rows[:, 0].tolist()


def test_the_same_stages_from_scratch_are_those_that_carry_nothing():
    point = replace(POINT, curriculum=NewGoals(layouts=2, zero_shot=2))
    nothing = replace(POINT, curriculum=NewGoals(layouts=2, zero_shot=2, carry="none"))
    assert stages_of(from_scratch(point)) == stages_of(nothing)
    assert fingerprint(from_scratch(point)) == fingerprint(nothing) == fingerprint(from_scratch(nothing))
    assert fingerprint(point) != fingerprint(nothing)


def test_one_stage_that_is_the_point_is_no_stage():
    alone = simulate(POINT)
    for curriculum in (Stages(stages=(Stage(),)), NewGoals(layouts=1)):
        curves = simulate(replace(POINT, curriculum=curriculum))
        assert curves.stages == ()
        np.testing.assert_array_equal(curves.steps, alone.steps)


def test_a_new_layout_is_the_same_for_all_points_of_equal_size_and_seed():
    def of_stage(number: int, **other: object) -> list[list[int]]:
        point = replace(POINT, **{"curriculum": NewGoals(layouts=3), **other})
        return stage_layouts(point, stages_of(point))[number].tolist()

    assert of_stage(1) == of_stage(1, representation=Direction(), world=Walled(size=6), exploration=Linear())
    assert of_stage(1) == of_stage(1, curriculum=ZeroShot(size=3))
    assert len({str(of_stage(number)) for number in range(3)}) == 3


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("most", [2**27, 1])
def test_shares_and_threads_do_not_change_results(threads: int, most: int, monkeypatch: pytest.MonkeyPatch):
    point = replace(POINT, curriculum=NewGoals(layouts=3), representation=Distance())
    expected = simulate(point, threads=1)
    monkeypatch.setattr(stages, "_SHARE_BYTES", most)
    monkeypatch.setattr(stage_learning, "_CODES_IN_FLIGHT", 500)
    found = simulate(point, threads=threads)
    np.testing.assert_array_equal(found.steps, expected.steps)
    np.testing.assert_array_equal([s.carried for s in found.stages], [s.carried for s in expected.stages])


def identical(before, after):
    """Return each state as its own ancestor."""
    states = before.codes[0].size
    return np.broadcast_to(np.arange(states).reshape(after.codes.shape[1:]), after.codes.shape)


def test_a_function_of_the_user_carries():
    halves = Stages(stages=(Stage.of({"task.trials": 5}), Stage.of({"task.trials": 7, "carry": identical})))
    np.testing.assert_array_equal(simulate(replace(POINT, curriculum=halves)).steps, simulate(POINT).steps)


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (lambda before, after: after.codes + 10**6, r"all from -1 to 71; it gives \d+ to \d+"),
        (lambda before, after: after.codes[0], r"of shape \(30, 2, 36\), not int64 of shape \(2, 36\)"),
        (lambda before, after: [], r"not list"),
    ],
)
def test_a_carry_rule_that_breaks_its_contract_is_refused(rule, message):
    point = replace(POINT, curriculum=Stages(stages=(Stage(), Stage(carry=rule))))
    with pytest.raises(ValueError, match=message):
        simulate(point, threads=1)


def test_more_periods_extend_a_result_and_a_precision_is_reached():
    point = replace(POINT, curriculum=NewGoals(layouts=3), representation=Distance())
    fewer = replace(point, task=replace(point.task, periods=11))
    whole, begun = simulate(point, threads=1), simulate(fewer, threads=1)
    extended = simulate(point, threads=2, begun=begun)
    np.testing.assert_array_equal(extended.steps, whole.steps)
    for one, other in zip(extended.stages, whole.stages, strict=True):
        assert all(np.array_equal(*pair) for pair in zip(one, other, strict=True))
    np.testing.assert_array_equal(simulate(fewer, begun=whole).stages[2].carried, begun.stages[2].carried)
    precise = simulate(replace(point, task=replace(point.task, precision=0.5)))
    assert {len(stage.optimum) for stage in precise.stages} == {len(precise.steps)}


def test_what_knows_one_stage_only_refuses_several():
    point = replace(POINT, curriculum=NewGoals())
    with pytest.raises(ConfigError, match="only periods of one stage can be learned again to look inside"):
        simulate(point, keep=["q"])
    with pytest.raises(ConfigError, match="an environment is one stage"):
        OrderedGoals(point)


def test_a_result_knows_its_stages():
    curves: LearningCurves = simulate(replace(POINT, curriculum=CoarseToFine(sizes=(3,), trials=5)))
    assert [(stage.trials, stage.side) for stage in curves.stages] == [(5, 3.0), (12, 6.0)]
    assert curves.steps.shape == (30, 17)
