"""This package, through its public function and with all that belongs to it.

Layouts are drawn and generators seeded within the measured time, although the peers get theirs as a gift; every
call has another seed, so that no cache helps.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

import rl_design_space
from benchmarks.job import Job
from benchmarks.peers import Learn
from rl_design_space.design import AdHoc, DesignPoint, GoalReward, Linear, QLearning, Task, Torus

TITLE = "rl-design-space"
PERIODS = 500


def version() -> str:
    """The tool that learns."""
    return f"rl-design-space {rl_design_space.__version__}, Numba {numba.__version__}"


def point(job: Job, periods: int, seed: int) -> DesignPoint:
    """The job as a design point."""
    return DesignPoint(
        seed=seed,
        task=Task(goals=job.goals, trials=job.trials, periods=periods, max_steps=job.max_steps),
        world=Torus(size=job.side),
        representation=AdHoc(),
        exploration=Linear(start=job.epsilon_start, k=job.epsilon_k),
        reward=GoalReward(step=job.step_reward, sub_goal=job.sub_goal_reward, final_goal=job.final_goal_reward),
        learner=QLearning(alpha=job.alpha, gamma=job.gamma),
    )


def prepare(job: Job) -> Learn:
    """Get ready for a job."""

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        # The seed is the one that the layouts come from.
        curves = rl_design_space.simulate(point(job, len(layouts), seed), threads=1)
        return curves.total_steps.astype(np.int64)

    return learn
