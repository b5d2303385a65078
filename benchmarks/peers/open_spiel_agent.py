"""OpenSpiel's tabular Q-learner, fed with time steps of the torus."""

# ruff: noqa: NPY002 (OpenSpiel draws from the global generator)

from __future__ import annotations

from importlib.metadata import version as installed

import numpy as np
from numpy.typing import NDArray
from open_spiel.python.algorithms.tabular_qlearner import QLearner
from open_spiel.python.rl_environment import StepType, TimeStep

from benchmarks.job import Job
from benchmarks.peers import Learn

TITLE = "OpenSpiel agent"
PERIODS = 10

_LEGAL_ACTIONS = [[0, 1, 2, 3]]


def version() -> str:
    """The tool that learns."""
    return f"OpenSpiel {installed('open_spiel')}"


class _PerTrial:
    """A schedule of ε that is set from outside; OpenSpiel asks for it after every step."""

    value = 0.0

    def step(self) -> float:
        return self.value


class _Learner(QLearner):  # type: ignore[misc]
    """OpenSpiel explores among all actions; here an exploratory action is any but the greedy one."""

    def _epsilon_greedy(
        self, info_state: str, legal_actions: list[int], epsilon: float
    ) -> tuple[int, NDArray[np.float64]]:
        values = self._q_values[info_state]
        best = max([values[a] for a in legal_actions])
        greedy_actions = [a for a in legal_actions if values[a] == best]
        greedy = len(greedy_actions)
        # Who is not the greedy one of the tied is explored like any other.
        probs = np.full(self._num_actions, epsilon / (self._num_actions - 1))
        probs[greedy_actions] = (1 - epsilon) / greedy + epsilon * (1 - 1 / greedy) / (self._num_actions - 1)
        return int(np.random.choice(range(self._num_actions), p=probs)), probs

    def forget_last_step(self) -> None:
        """A trial that ran out of steps is followed by a new one, not by a terminal state."""
        self._prev_info_state = None


def _time_step(state: int, reward: float | None, kind: StepType) -> TimeStep:
    observations = {"info_state": [[state]], "legal_actions": _LEGAL_ACTIONS, "current_player": 0}
    return TimeStep(observations, [reward], [1.0], kind)


def _trial(job: Job, agent: _Learner, layout: list[int], next_cell: list[list[int]]) -> int:
    start, *goals = layout
    cell, reached = start, 0
    time_step = _time_step(cell, None, StepType.FIRST)
    for steps in range(1, job.max_steps + 1):
        cell = next_cell[agent.step(time_step).action][cell]
        reward = job.step_reward
        if cell == goals[reached]:
            reached += 1
            if reached == job.goals:
                agent.step(_time_step(0, job.final_goal_reward, StepType.LAST))
                return steps
            reward = job.sub_goal_reward
        time_step = _time_step(reached * job.cells + cell, reward, StepType.MID)
    agent.step(time_step)
    agent.forget_last_step()
    return job.max_steps


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    next_cell = job.next_cell().tolist()
    epsilons = job.epsilon().tolist()

    def learn_period(layout: list[int]) -> int:
        schedule = _PerTrial()
        agent = _Learner(0, 4, step_size=job.alpha, epsilon_schedule=schedule, discount_factor=job.gamma)
        total = 0
        for epsilon in epsilons:
            schedule.value = agent._epsilon = epsilon
            total += _trial(job, agent, layout, next_cell)
        return total

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        np.random.seed(seed)
        return np.array([learn_period(layout) for layout in layouts.tolist()])

    return learn
