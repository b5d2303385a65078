"""Numba as one writes it at first: np.random, coordinates modulo the side, argmax over a slice."""

# ruff: noqa: NPY002 (what Numba compiles fast is the old interface)

from __future__ import annotations

import numba
import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn

TITLE = "Numba, plain"
PERIODS = 500


def version() -> str:
    """The tool that learns."""
    return f"Numba {numba.__version__}"


@njit
def _greedy(q):
    """A random one of the best actions."""
    greedy = 0
    tied = 1
    for action in range(1, len(q)):
        if q[action] > q[greedy]:
            greedy = action
            tied = 1
        elif q[action] == q[greedy]:
            tied += 1
            # The n-th of them takes the place with probability 1/n.
            if np.random.random() * tied < 1.0:
                greedy = action
    return greedy


@njit
def _choose(q, epsilon):
    greedy = _greedy(q)
    if np.random.random() >= epsilon:
        return greedy
    return (greedy + np.random.randint(1, len(q))) % len(q)


@njit
def _move(x, y, action, side):
    if action == 0:
        return (x + 1) % side, y
    if action == 1:
        return (x - 1) % side, y
    if action == 2:
        return x, (y - 1) % side
    return x, (y + 1) % side


@njit
def _trial(q, layout, epsilon, side, max_steps, alpha, gamma, rewards):
    n_goals = len(layout) - 1
    y, x = divmod(layout[0], side)
    reached = 0
    steps = 0
    while reached < n_goals and steps < max_steps:
        values = q[reached, y, x]
        action = _choose(values, epsilon)
        x, y = _move(x, y, action, side)
        steps += 1
        reward = rewards[0]
        if y * side + x == layout[1 + reached]:
            reached += 1
            reward = rewards[2] if reached == n_goals else rewards[1]
        target = reward
        if reached < n_goals:
            target += gamma * q[reached, y, x].max()
        values[action] += alpha * (target - values[action])
    return steps


@njit
def _learn(layouts, seed, epsilon, side, max_steps, alpha, gamma, rewards):
    np.random.seed(seed)
    total = np.zeros(len(layouts), dtype=np.int64)
    for period in range(len(layouts)):
        q = np.zeros((layouts.shape[1] - 1, side, side, 4))
        for trial in range(len(epsilon)):
            total[period] += _trial(q, layouts[period], epsilon[trial], side, max_steps, alpha, gamma, rewards)
    return total


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    epsilon = job.epsilon()
    rewards = (job.step_reward, job.sub_goal_reward, job.final_goal_reward)

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        total: NDArray[np.int64] = _learn(
            layouts, seed, epsilon, job.side, job.max_steps, job.alpha, job.gamma, rewards
        )
        return total

    return learn
