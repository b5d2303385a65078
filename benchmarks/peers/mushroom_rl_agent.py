"""MushroomRL: its Q-learning agent, its policy and its Core, on an environment of the torus."""

# ruff: noqa: NPY002 (MushroomRL draws from the global generator)

from __future__ import annotations

from typing import Any

import mushroom_rl
import numpy as np
from mushroom_rl.algorithms.value import QLearning
from mushroom_rl.core import Core, Environment, MDPInfo
from mushroom_rl.policy import EpsGreedy
from mushroom_rl.utils.parameters import Parameter
from mushroom_rl.utils.spaces import Discrete
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn

TITLE = "MushroomRL agent"
PERIODS = 5


def version() -> str:
    """The tool that learns."""
    return f"MushroomRL {mushroom_rl.__version__}"


class _Torus(Environment):  # type: ignore[misc]
    def __init__(self, job: Job, layout: list[int]) -> None:
        self.job = job
        self.start, *self.goals = layout
        self.next_cell = job.next_cell().tolist()
        self.steps = 0
        super().__init__(MDPInfo(Discrete(job.states), Discrete(4), job.gamma, job.max_steps))

    def reset(self, state: Any = None) -> NDArray[np.int64]:
        self.cell, self.reached = self.start, 0
        return np.array([self.cell])

    def step(self, action: NDArray[np.int64]) -> tuple[NDArray[np.int64], float, bool, dict[str, Any]]:
        self.steps += 1
        self.cell = self.next_cell[action[0]][self.cell]
        reward = self.job.step_reward
        if self.cell == self.goals[self.reached]:
            self.reached += 1
            if self.reached == self.job.goals:
                return np.array([0]), self.job.final_goal_reward, True, {}
            reward = self.job.sub_goal_reward
        return np.array([self.reached * self.job.cells + self.cell]), reward, False, {}


class _NonGreedy(EpsGreedy):  # type: ignore[misc]
    """MushroomRL explores among all actions; here an exploratory action is any but the greedy one."""

    def draw_action(self, state: NDArray[np.int64]) -> NDArray[np.int64]:
        q = self._approximator.predict(state)
        best = np.argwhere(q == np.max(q)).ravel()
        greedy = best[0] if len(best) == 1 else np.random.choice(best)
        if np.random.uniform() < self._epsilon(state):
            return np.array([(greedy + np.random.randint(1, 4)) % 4])
        return np.array([greedy])


def _learn_period(job: Job, layout: list[int]) -> int:
    environment = _Torus(job, layout)
    policy = _NonGreedy(epsilon=0.0)
    core = Core(QLearning(environment.info, policy, Parameter(job.alpha)), environment)
    for epsilon in job.epsilon():
        policy.set_epsilon(epsilon)
        core.learn(n_episodes=1, n_steps_per_fit=1, quiet=True)
    return environment.steps


def prepare(job: Job) -> Learn:
    """Get ready for a job."""

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        np.random.seed(seed)
        return np.array([_learn_period(job, layout) for layout in layouts.tolist()])

    return learn
