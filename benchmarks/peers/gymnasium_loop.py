"""A Gymnasium environment and the loop of every tutorial, with a Q-table in NumPy."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Discrete
from gymnasium.wrappers import TimeLimit
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn

TITLE = "Gymnasium loop"
PERIODS = 15

_MOVES = ((1, 0), (-1, 0), (0, -1), (0, 1))


def version() -> str:
    """The tool that learns."""
    return f"Gymnasium {gymnasium.__version__}"


class GoalsInOrder(gymnasium.Env[Any, Any]):
    """A torus with goals that count in their order."""

    def __init__(self, job: Job, layout: list[int]) -> None:
        self.job = job
        self.start, *self.goals = layout
        self.observation_space = Discrete(job.states)
        self.action_space = Discrete(4)

    def _observation(self) -> int:
        return (self.reached * self.job.side + self.y) * self.job.side + self.x

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.y, self.x = divmod(self.start, self.job.side)
        self.reached = 0
        return self._observation(), {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        move_x, move_y = _MOVES[action]
        self.x = (self.x + move_x) % self.job.side
        self.y = (self.y + move_y) % self.job.side
        reward = self.job.step_reward
        if self.y * self.job.side + self.x == self.goals[self.reached]:
            self.reached += 1
            if self.reached == len(self.goals):
                return 0, self.job.final_goal_reward, True, False, {}
            reward = self.job.sub_goal_reward
        return self._observation(), reward, False, False, {}


def _choose(values: NDArray[np.float64], epsilon: float, rng: np.random.Generator) -> int:
    best = np.flatnonzero(values == values.max())
    greedy = int(best[rng.integers(len(best))])
    if rng.random() >= epsilon:
        return greedy
    return (greedy + int(rng.integers(1, 4))) % 4


def _learn_period(job: Job, layout: list[int], rng: np.random.Generator) -> int:
    env = TimeLimit(GoalsInOrder(job, layout), max_episode_steps=job.max_steps)
    q = np.zeros((job.states, 4))
    total = 0
    for epsilon in job.epsilon():
        state, _ = env.reset()
        done = False
        while not done:
            action = _choose(q[state], epsilon, rng)
            next_state, reward, terminated, truncated, _ = env.step(action)
            target = reward if terminated else reward + job.gamma * np.max(q[next_state])
            q[state, action] += job.alpha * (target - q[state, action])
            state = next_state
            done = terminated or truncated
            total += 1
    return total


def prepare(job: Job) -> Learn:
    """Get ready for a job."""

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        rng = np.random.default_rng(seed)
        return np.array([_learn_period(job, layout, rng) for layout in layouts.tolist()])

    return learn
