"""The compiled learner and the reference implementation agree bit for bit on any design point."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings

from rl_design_space.design import (
    DesignPoint,
    Direction,
    Distance,
    GoalReward,
    Linear,
    MultiStepActions,
    QLearning,
    Task,
    Torus,
    Walled,
)
from rl_design_space.learning import simulate
from tests import reference
from tests.learning import strategies
from tests.learning.plays import play_period
from tests.reference_streams import Xoshiro, generator_of, layout_of


def assert_same_curves(point: DesignPoint) -> None:
    curves = simulate(point, threads=1)
    periods = reference.learn(point)
    np.testing.assert_array_equal(curves.steps, [period.steps for period in periods])
    np.testing.assert_array_equal(curves.success, [period.success for period in periods])
    initial = point.learner.initial_q
    rows = [(len(period.q), sum(set(values) != {initial} for values in period.q.values())) for period in periods]
    np.testing.assert_array_equal(curves.rows, rows)


def assert_same_q_matrix(point: DesignPoint) -> None:
    last = point.task.periods - 1
    played, codes = play_period(point, last)
    expected = reference.learn_period(point, layout_of(point, last), generator_of(point, last))
    assert (played.steps, played.success) == (expected.steps, expected.success)
    assert codes.tolist() == sorted(expected.q)
    values = np.array([expected.q[code] for code in codes.tolist()])
    assert played.q.tobytes() == values.tobytes(), f"largest difference {np.abs(played.q - values).max()}"


def test_the_reference_draws_the_published_words_of_xoshiro256pp():
    generator = Xoshiro([1, 2, 3, 4])
    words = [generator.next_word() for _ in range(5)]
    assert words == [41943041, 58720359, 3588806011781223, 3591011842654386, 9228616714210784205]


@settings(deadline=None, max_examples=150)
@given(point=strategies.points())
def test_steps_and_success_of_all_periods_agree(point: DesignPoint):
    assert_same_curves(point)


@settings(deadline=None, max_examples=150)
@given(point=strategies.points())
def test_the_q_matrix_agrees_bit_for_bit(point: DesignPoint):
    assert_same_q_matrix(point)


@settings(deadline=None, max_examples=30)
@given(point=strategies.tabulated_points)
def test_steps_and_success_of_actions_that_follow_a_table_agree(point: DesignPoint):
    assert_same_curves(point)


@settings(deadline=None, max_examples=30)
@given(point=strategies.tabulated_points)
def test_the_q_matrix_of_actions_that_follow_a_table_agrees_bit_for_bit(point: DesignPoint):
    assert_same_q_matrix(point)


DEFAULT = DesignPoint(task=Task(periods=3))
EXAMPLES = {
    "default": DEFAULT,
    "direction": replace(DEFAULT, representation=Direction(), exploration=Linear(k=0.02)),
    "distance_to_all": replace(DEFAULT, representation=Distance(goals="all")),
    "msa_3": replace(DEFAULT, msa=MultiStepActions(lengths=(3,))),
    "msa_2_5_all_shorter": replace(DEFAULT, msa=MultiStepActions(lengths=(2, 5), propagation="all_shorter")),
    "msa_long_first": replace(DEFAULT, msa=MultiStepActions(lengths=(5, 2), propagation="all_shorter")),
    "msa_printed_stop": replace(DEFAULT, msa=MultiStepActions(lengths=(6,), reward="printed", sub_goal="stop")),
    "paper_to_the_letter": replace(
        DEFAULT,
        task=Task(periods=2, max_steps=500),
        reward=GoalReward(step=0.0, sub_goal=0.0),
        learner=QLearning(explore="all", ties="first", out_of_order="zero", update="printed"),
    ),
    "walled_rectangle": replace(DEFAULT, world=Walled(size=(7, 3)), seed=2**64 - 1),
    "more_periods_than_lanes": replace(DEFAULT, task=Task(periods=60, trials=8, goals=2), world=Torus(size=4)),
    "more_periods_than_lanes_msa_2_3_5": replace(
        DEFAULT,
        task=Task(periods=60, trials=8, goals=2),
        world=Torus(size=4),
        representation=Direction(),
        msa=MultiStepActions(lengths=(2, 3, 5)),
    ),
    "capped": replace(DEFAULT, task=Task(periods=3, goals=2, max_steps=17), world=Torus(size=(6, 9))),
}


@dataclass(frozen=True, kw_only=True)
class InATable(MultiStepActions):
    """Multi-step actions that are learned by the general form."""

    @property
    def repeats(self) -> bool:
        return False


@pytest.mark.parametrize("propagation", ["none", "primitives", "all_shorter"])
@pytest.mark.parametrize("reward", ["realised", "printed"])
def test_multi_step_actions_are_a_special_case_of_a_table(propagation: str, reward: str):
    readings = {"lengths": (3,), "propagation": propagation, "reward": reward}
    special = replace(DEFAULT, representation=Direction(), msa=MultiStepActions(**readings))
    general = replace(special, msa=InATable(**readings))
    (one, codes), (other, again) = play_period(special, 0), play_period(general, 0)
    assert codes.tolist() == again.tolist()
    assert one.q.tobytes() == other.q.tobytes()
    assert one.steps == other.steps


@pytest.mark.parametrize("name", EXAMPLES)
def test_pinned_points_agree(name: str):
    assert_same_curves(EXAMPLES[name])
    assert_same_q_matrix(EXAMPLES[name])
