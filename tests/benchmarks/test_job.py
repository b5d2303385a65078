"""The job that peers are given is the one that ours is given as a design point."""

from __future__ import annotations

import numpy as np

from benchmarks.job import Job
from benchmarks.peers import ours
from rl_design_space.learning import simulate
from rl_design_space.learning.streams import layouts


def test_the_job_is_the_default_task_with_linear_exploration():
    point = ours.point(Job(), periods=500, seed=0)
    changed = type(point)(exploration=point.exploration)
    assert point == changed


def test_world_and_schedule_are_those_of_the_design_point():
    job = Job(side=7, trials=40, epsilon_k=0.05)
    point = ours.point(job, periods=1, seed=0)
    np.testing.assert_array_equal(job.next_cell(), point.world.next_cell())
    np.testing.assert_array_equal(job.epsilon(), point.exploration.schedule(40))


def test_ours_learns_as_many_periods_as_there_are_layouts():
    job = Job(side=5, goals=2, trials=3)
    total = ours.prepare(job)(layouts(4, job.cells, job.goals, 6), 4)
    np.testing.assert_array_equal(total, simulate(ours.point(job, 6, 4), threads=1).total_steps)
