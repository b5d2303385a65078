"""Chance and rewards by transition: agreement with the reference learner, replays, and worlds that are certain."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from rl_design_space.design import (
    Controllers,
    DesignPoint,
    Direct,
    Direction,
    MultiStepActions,
    NStep,
    Outcomes,
    Sarsa,
    ShapedReward,
    Slip,
    Stage,
    Stages,
    Task,
    Torus,
    Wind,
    cell_count,
)
from rl_design_space.learning import simulate
from rl_design_space.learning.checked import outcomes
from rl_design_space.learning.replay import Replayer
from tests.learning.test_against_reference import assert_same_curves, assert_same_q_matrix
from tests.learning.test_learners import assert_agrees as assert_learner_agrees


@dataclass(frozen=True, kw_only=True)
class Mixed(ShapedReward):
    """A potential, and rewards that differ by state, step and outcome."""

    by_outcome: bool = True

    def by_transition(self, world, goals):
        outcomes = world.outcomes().cells.shape[-1] if self.by_outcome else 1
        shape = (*goals.shape, 4, cell_count(world), outcomes)
        table = np.sin(np.arange(np.prod(shape[-4:]), dtype=np.float64)).reshape(shape[-4:])
        found = np.broadcast_to(table, shape) + goals[..., np.newaxis, np.newaxis, np.newaxis] / 7
        return found if self.by_outcome else found[..., 0]


#: Chance and rewards by transition together, so that the kernel is compiled once for each kind of actions.
POINT = DesignPoint(
    task=Task(goals=2, trials=8, periods=30, max_steps=400),
    world=Slip(size=(5, 4), p=0.3, astray="others"),
    reward=Mixed(shaping="due_goal"),
)
POINTS = {
    "primitive": POINT,
    "walled, by step": replace(POINT, world=Slip(size=5, border="walled"), reward=Mixed(by_outcome=False, weight=-2.0)),
    "wind": replace(POINT, world=Wind(size=(6, 5), border="walled"), representation=Direction()),
    "length 3": replace(POINT, msa=MultiStepActions(lengths=(3,), sub_goal="stop"), reward=Mixed()),
    "until the observation changes": replace(
        POINT, msa=MultiStepActions(lengths=(4,), until="observation_changes", propagation="consistent")
    ),
    "controllers": replace(
        POINT,
        representation=Direct(),
        msa=Controllers(controllers=("goal_along_x", "goal_along_y", "along_wall", "back_to_sub_goal")),
        world=Slip(size=4, border="walled", astray="stays"),
    ),
}


@pytest.mark.parametrize("name", POINTS)
def test_the_reference_learner_agrees_bit_for_bit(name: str):
    assert_same_curves(POINTS[name])
    assert_same_q_matrix(POINTS[name])


@pytest.mark.parametrize("learner", [Sarsa(), NStep(n=3, backup="tree")], ids=["sarsa", "tree backup"])
def test_other_learners_agree_with_the_plain_one(learner):
    assert_learner_agrees(replace(POINT, task=replace(POINT.task, periods=3), learner=learner))


def test_a_period_does_not_depend_on_the_others():
    one = simulate(replace(POINT, task=replace(POINT.task, periods=3)), threads=1)
    np.testing.assert_array_equal(simulate(POINT, threads=2).first(3).steps, one.steps)


@pytest.mark.parametrize("astray", ["sides", "left", "right", "others", "stays"])
def test_without_probability_a_slip_changes_no_bit(astray: str):
    plain = DesignPoint(task=Task(periods=2, trials=10), world=Torus(size=5))
    slip = replace(plain, world=Slip(size=5, p=0.0, astray=astray))
    assert outcomes(slip) is None
    for name in ("steps", "success", "optimum", "rows"):
        expected = getattr(simulate(plain, 1), name)
        found = getattr(simulate(slip, 1), name)
        np.testing.assert_array_equal(found, expected)
        assert found.dtype == expected.dtype


def test_replayed_steps_go_astray_as_often_as_they_should():
    point = POINTS["length 3"]
    replay = Replayer(point)(1)
    possible, straight = point.world.outcomes().cells, point.world.next_cell()
    astray = []
    for path, steps in zip(replay.paths, replay.steps, strict=True):
        assert len(path.actions) == steps
        before, after = path.cells[:-1], path.cells[1:]
        assert (possible[path.actions % 4, before] == after[:, np.newaxis]).any(axis=1).all()
        assert path.cells[-1] == replay.layout[2] or path.counters[-1] < 2
        astray += (straight[path.actions % 4, before] != after).tolist()
    np.testing.assert_array_equal(replay.steps, simulate(point, threads=1).steps[1])
    p = point.world.p
    assert np.mean(astray) == pytest.approx(p, abs=4 * np.sqrt(p * (1 - p) / len(astray)))


def test_stages_may_differ_in_chance_and_in_rewards():
    stages = Stages(stages=(Stage(), Stage(changes={"world.p": 0.1}), Stage(changes={"world.p": 0.5})))
    result = simulate(replace(POINT, curriculum=stages, task=replace(POINT.task, periods=3)), threads=1)
    middle, calm, wild = (stage.optimum for stage in result.stages)
    assert ((calm < middle) & (middle < wild)).all()


@dataclass(frozen=True, kw_only=True)
class Broken(Torus):
    """A stochastic world that breaks its contract."""

    factor: float = 1.0
    beyond: int = 0

    def outcomes(self):
        cells, probabilities = Slip(size=self.size).outcomes()
        return Outcomes(cells + np.int32(self.beyond), probabilities * self.factor)


@pytest.mark.parametrize(
    ("world", "message"),
    [
        (
            Broken(factor=0.5),
            r"Broken.outcomes\(\): probabilities should add up to 1; .* step 0 from cell 0 add up to 0.5",
        ),
        (Broken(beyond=1), r"Broken.outcomes\(\) should give int32 of shape \(4, 100, 3\), all from 0 to 99"),
    ],
)
def test_outcomes_that_break_the_contract_are_refused(world: Broken, message: str):
    with pytest.raises(ValueError, match=message):
        simulate(DesignPoint(world=world))
