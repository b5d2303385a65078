"""Estimates of how long points take."""

from __future__ import annotations

import pytest

from rl_design_space.design import DesignPoint, Task
from rl_design_space.plan.cost import Estimate, estimate, expected_steps
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


def test_a_server_takes_longer_than_a_database():
    uris = ("sqlite:///mlflow.db", "http://127.0.0.1:5000")
    database, server = (seconds_to_record(MlflowTracking(uri=uri)) for uri in uris)
    assert seconds_to_record(NoTracking()) == 0 < database < server
