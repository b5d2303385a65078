"""Estimates of how long points take."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rl_design_space.design import (
    DesignPoint,
    DoubleQ,
    DynaQ,
    ExpectedSarsa,
    Linear,
    NewGoals,
    NStep,
    QLambda,
    QLearning,
    Sarsa,
    TabularLearner,
    Task,
)
from rl_design_space.plan.cost import Estimate, estimate, expected_steps, expected_work
from rl_design_space.tracking import MlflowTracking, NoTracking
from rl_design_space.tracking.backends import seconds_to_record

POINTS = [DesignPoint(task=Task(periods=periods)) for periods in (50, 500)]


def test_nothing_takes_no_time():
    assert estimate([], 2, 0.1) == Estimate(0, 0, 0)


def test_learning_is_shared_by_threads_and_recording_is_not():
    one, two = (estimate(POINTS * 50, threads, record=1.0) for threads in (1, 2))
    assert one.learning == two.learning > 0
    assert one.recording == two.recording == 100
    assert two.total >= 100
    assert one.total - two.total == pytest.approx(one.learning, rel=0.01)


def test_a_point_takes_time_by_its_steps():
    few, many = map(expected_steps, POINTS)
    assert many == pytest.approx(10 * few)


@pytest.mark.parametrize(
    ("learner", "measured"),  # processor time over that of Q-learning, ad hoc, linear schedule, k = 0.03
    [
        (QLearning(), 1.0),
        (QLearning(alpha=1.0, alpha_schedule="visits"), 2.7),
        (QLearning(alpha=1.0, alpha_schedule="polynomial"), 7.4),
        (Sarsa(), 2.8),
        (ExpectedSarsa(), 4.2),
        (DoubleQ(), 3.9),
        (NStep(n=1), 3.5),
        (NStep(n=4), 3.4),
        (NStep(n=10), 4.3),
        (NStep(n=4, backup="tree"), 9.6),
        (NStep(n=10, backup="tree"), 21.5),
        (QLambda(trace_decay=0.8), 3.6),
        (DynaQ(planning=1), 4.4),
        (DynaQ(planning=10), 18.3),
        (DynaQ(planning=50), 82.0),
    ],
)
def test_an_estimate_knows_what_a_learner_costs(learner: TabularLearner, measured: float):
    usual = DesignPoint(exploration=Linear(k=0.03))
    found = expected_work(replace(usual, learner=learner)) / expected_work(usual)
    assert 1 / 1.5 < found / measured < 1.5


def test_stages_cost_what_their_learners_do():
    one, both = DesignPoint(), NewGoals(layouts=2)
    usual, planning = (expected_work(replace(one, curriculum=both, learner=each)) for each in (QLearning(), DynaQ()))
    assert usual == 2 * expected_work(one)
    assert planning > 10 * usual


def test_a_server_takes_longer_than_a_database():
    uris = ("sqlite:///mlflow.db", "http://127.0.0.1:5000")
    database, server = (seconds_to_record(MlflowTracking(uri=uri)) for uri in uris)
    assert seconds_to_record(NoTracking()) == 0 < database < server
