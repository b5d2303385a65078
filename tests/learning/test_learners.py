"""Learners, step sizes and behaviours agree bit for bit with plain ones, and converge where theory promises it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import (
    Constant,
    DesignPoint,
    DoubleQ,
    DynaQ,
    ErrorDriven,
    ExpectedSarsa,
    Linear,
    MultiStepActions,
    NewGoals,
    NStep,
    Optimistic,
    OwnLearner,
    QLambda,
    QLearning,
    Sarsa,
    Softmax,
    SuccessDriven,
    TabularLearner,
    Task,
    Torus,
    UpperConfidenceBound,
)
from rl_design_space.learning import simulate
from rl_design_space.learning.optimal_values import optimal_values
from rl_design_space.learning.replay import Replayer
from rl_design_space.learning.sequential import elementary
from tests import reference_functions, reference_learners
from tests.learning import strategies
from tests.learning.plays import play_period
from tests.reference_streams import layout_of

LEARNERS: dict[str, TabularLearner] = {
    "q_learning": QLearning(alpha_schedule="visits"),
    "sarsa": Sarsa(),
    "expected_sarsa": ExpectedSarsa(),
    "double_q": DoubleQ(),
    "n_step_sarsa": NStep(n=3),
    "n_step_tree": NStep(n=3, backup="tree"),
    "replacing": QLambda(),
    "accumulating": QLambda(traces="accumulating"),
    "dyna_q": DynaQ(planning=3),
}
BEHAVIOURS = {
    "epsilon": Linear(start=0.5, k=0.1),
    "softmax": Softmax(temperature=2.0, fall=1.5),
    "bonus": UpperConfidenceBound(),
    "optimistic": Optimistic(scale=0.5, epsilon=0.1),
    "success": SuccessDriven(factor=0.7),
    "error": ErrorDriven(lowest=0.05),
}
SMALL = DesignPoint(task=Task(goals=2, trials=6, periods=2, max_steps=150), world=Torus(size=4))


def assert_agrees(point: DesignPoint) -> None:
    """Compare all periods, and the Q-matrix of the last one, with those of the plain learner."""
    curves = simulate(point, threads=1)
    periods = [reference_learners.learn_period(point, number) for number in range(point.task.periods)]
    np.testing.assert_array_equal(curves.steps, [period.steps for period in periods])
    np.testing.assert_array_equal(curves.success, [period.success for period in periods])
    played, codes = play_period(point, point.task.periods - 1)
    expected = np.array([periods[-1].q[code] for code in codes.tolist()])
    assert played.q.tobytes() == expected.tobytes(), f"largest difference {np.abs(played.q - expected).max()}"


@pytest.mark.parametrize("behaviour", BEHAVIOURS)
@pytest.mark.parametrize("learner", LEARNERS)
def test_every_learner_agrees_with_the_plain_one_under_every_behaviour(learner: str, behaviour: str):
    assert_agrees(replace(SMALL, learner=LEARNERS[learner], exploration=BEHAVIOURS[behaviour]))


@st.composite
def points(draw: st.DrawFn) -> DesignPoint:
    """Draw small points of any learner, step size, reading and behaviour."""
    point = draw(strategies.points(st.just(MultiStepActions())))
    exploration = draw(st.just(point.exploration) | st.sampled_from(list(BEHAVIOURS.values())))
    optimistic = isinstance(exploration, Optimistic)
    epsilon = not isinstance(exploration, (Softmax, UpperConfidenceBound))
    read = point.learner
    learner = replace(
        draw(st.sampled_from(list(LEARNERS.values()))),
        alpha=read.alpha,
        gamma=read.gamma,
        initial_q=0.0 if optimistic else read.initial_q,
        explore=read.explore if epsilon else "non_greedy",
        ties=read.ties,
        out_of_order=read.out_of_order,
        **draw(
            st.sampled_from(
                [
                    {"alpha_schedule": "constant"},
                    {"alpha_schedule": "visits"},
                    {"alpha_schedule": "linear", "alpha_fall": 0.05},
                    {"alpha_schedule": "polynomial", "alpha_power": 0.6},
                ]
            )
        ),
    )
    return replace(point, learner=learner, exploration=exploration, task=replace(point.task, periods=2))


@settings(deadline=None, max_examples=40)
@given(point=points())
def test_any_point_agrees_with_the_plain_learner(point: DesignPoint):
    assert_agrees(point)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (QLearning(), QLearning(alpha_schedule="linear", alpha_fall=0.0)),
        (QLearning(), QLambda(trace_decay=0.0)),
        (QLearning(), DynaQ(planning=0)),
        (QLearning(), OwnLearner()),
        (Sarsa(), NStep(n=1)),
        (ExpectedSarsa(), NStep(n=1, backup="tree")),
    ],
    ids=str,
)
def test_learners_that_mean_the_same_learn_the_same(one: TabularLearner, other: TabularLearner):
    point = replace(SMALL, exploration=Linear(k=0.2), task=replace(SMALL.task, periods=30))
    curves, again = (simulate(replace(point, learner=learner)) for learner in (one, other))
    np.testing.assert_array_equal(curves.steps, again.steps)
    np.testing.assert_array_equal(curves.rows, again.rows)


CONVERGING = {
    "q_learning": QLearning(alpha=1.0, alpha_schedule="polynomial", explore="all"),
    "double_q": DoubleQ(alpha=1.0, alpha_schedule="polynomial", explore="all"),
    "dyna_q": DynaQ(alpha=0.5, planning=5, explore="all"),
    "tree": NStep(alpha=0.1, n=1, backup="tree"),
    "sarsa": Sarsa(alpha=0.5),
    "expected_sarsa": ExpectedSarsa(alpha=0.5),
    "traces": QLambda(alpha=0.2, explore="all"),
}


@pytest.mark.parametrize("name", CONVERGING)
def test_learners_converge_to_the_values_of_dynamic_programming(name: str):
    """Behaviour is random, or for on-policy learners ε falls to 0; then all values become the optimal ones."""
    learner = CONVERGING[name]
    on_policy = learner.explore == "non_greedy"
    exploration = Linear(start=0.5, k=0.0002) if on_policy else Constant(epsilon=1.0)
    point = DesignPoint(
        seed=5,
        world=Torus(size=3),
        task=Task(goals=2, trials=6000, periods=1),
        exploration=exploration,
        learner=learner,
    )
    layout = layout_of(point, 0)
    rewards = point.reward.table()
    best = optimal_values(point.world.next_cell(), np.array(layout[1:]), rewards, 0.9, rewards[0]).max(axis=0)
    learned = play_period(point, 0)[0].q.reshape(2, 9, 4)
    # On the greedy path from the start, which is tried for ever.
    cell, reached = layout[0], 0
    while reached < 2:
        assert math.isclose(learned[reached, cell].max(), best[reached, cell], rel_tol=0.02)
        cell = int(point.world.next_cell()[learned[reached, cell].argmax(), cell])
        reached += cell == layout[1 + reached]


def test_own_functions_are_those_of_mathematics():
    for x in np.linspace(-40, 0, 400).tolist():
        assert math.isclose(elementary.exponential(x), math.exp(x), rel_tol=4e-16)
        assert elementary.exponential(x) == reference_functions.exponential(x)
    for count in (1, 2, 3, 7, 100, 12345, 2**31):
        assert math.isclose(elementary.logarithm(count), math.log(count), rel_tol=4e-16, abs_tol=1e-16)
    assert elementary.exponential(-800.0) == 0.0


@pytest.mark.parametrize("learner", [Sarsa(), NStep(), QLambda(), DynaQ(), DoubleQ()], ids=str)
def test_a_period_can_be_looked_into(learner: TabularLearner):
    point = replace(SMALL, learner=learner, exploration=UpperConfidenceBound())
    inside = Replayer(point)(1)
    assert inside.steps.tolist() == simulate(point).steps[1].tolist()
    for path, steps, solved in zip(inside.paths, inside.steps.tolist(), inside.success.tolist(), strict=True):
        assert len(path.actions) == steps
        assert (path.counters[-1] == point.task.goals) == solved
        moved = point.world.next_cell()[path.actions, path.cells[:-1]]
        np.testing.assert_array_equal(moved, path.cells[1:])
    np.testing.assert_array_equal(inside.history[-1], inside.q)


@pytest.mark.parametrize("learner", [Sarsa(), DoubleQ(), DynaQ()], ids=str)
def test_stages_carry_what_a_learner_has_learned(learner: TabularLearner):
    task = replace(SMALL.task, periods=20, trials=30)
    point = replace(SMALL, learner=learner, exploration=Constant(), task=task)
    carried = simulate(replace(point, curriculum=NewGoals(layouts=2, layout="same"))).steps
    np.testing.assert_array_equal(carried[:, :30], simulate(point).steps)
    assert carried[:, 30:33].mean() < 0.7 * carried[:, :3].mean()


def test_more_periods_continue_those_that_were_learned():
    point = replace(SMALL, exploration=SuccessDriven(), learner=ExpectedSarsa())
    more = replace(point, task=replace(point.task, periods=5))
    assert np.isnan(simulate(point).epsilon).all()
    np.testing.assert_array_equal(simulate(more, begun=simulate(point)).steps, simulate(more, threads=2).steps)
