"""Let a deep Q-network learn the task beside the tables: `python docs/dqn.py [OUTPUTS]`.

Learns a small point with tables, and with the DQN of stable-baselines3 through the Gymnasium environment, on the same
starts and goals. Records both, and prints how they compare. See docs/deep-learners.md.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import DQN
from stable_baselines3.common.callbacks import BaseCallback

import rl_design_space as rds
import rl_design_space.environment  # registers the environment

POINT = rds.DesignPoint(
    world=rds.Torus(size=5),
    task=rds.Task(goals=2, trials=40, periods=10, max_steps=500),
    exploration=rds.Linear(k=0.05),
)
#: Of the network; what is not named is the default of stable-baselines3.
SETTINGS: dict[str, Any] = {
    "gamma": POINT.learner.gamma,
    "learning_rate": 1e-3,
    "batch_size": 32,
    "buffer_size": 5_000,
    "learning_starts": 100,
    "train_freq": 1,
    "target_update_interval": 200,
    "policy_kwargs": {"net_arch": [64]},
}
#: ε falls from 0.9 to 0 over so many steps of a period.
EXPLORING = 1_000


class Trials(BaseCallback):
    """Counts the steps of each trial, and ends the learning after the last one."""

    def __init__(self, trials: int) -> None:
        super().__init__()
        self.trials = trials
        self.steps: list[int] = []
        self.success: list[bool] = []

    def _on_step(self) -> bool:
        if self.locals["dones"][0]:
            info = self.locals["infos"][0]
            self.steps.append(info["moves"])
            self.success.append(not info["TimeLimit.truncated"])
        return len(self.steps) < self.trials


def learned(point: rds.DesignPoint, period: int) -> Trials:
    """Learn all trials of a period with a new network."""
    # The observation is a row of the Q-matrix; stable-baselines3 gives it to the network as one of so many inputs.
    env = gymnasium.make("rl_design_space/OrderedGoals-v0", point=point, period=period)
    at_most = point.task.trials * point.task.max_steps
    network = DQN(
        "MlpPolicy",
        env,
        seed=period,
        device="cpu",
        exploration_initial_eps=0.9,
        exploration_final_eps=0.0,
        exploration_fraction=EXPLORING / at_most,
        **SETTINGS,
    )
    trials = Trials(point.task.trials)
    network.learn(at_most, callback=trials)
    return trials


def measured(point: rds.DesignPoint) -> dict[str, NDArray[Any]]:
    """Learn all periods."""
    found = [learned(point, period) for period in range(point.task.periods)]
    return {
        "steps": np.array([each.steps for each in found]),
        "success": np.array([each.success for each in found]),
    }


def main() -> None:
    """Learn, record and compare."""
    torch.set_num_threads(1)
    outputs = sys.argv[1] if len(sys.argv) > 1 else "outputs"
    points = [POINT, replace(POINT, learner=rds.QLearning(alpha=1.0))]
    rds.sweep(points, outputs=outputs, progress=False)
    begun = perf_counter()
    curves = measured(POINT)
    seconds = perf_counter() - begun
    choices = {"learner.learning_rate": SETTINGS["learning_rate"], "learner.hidden": 64, "exploration.steps": EXPLORING}
    rds.record(POINT, curves, learner="dqn", choices=choices, seconds=seconds, outputs=outputs)
    compared = {"table, α = 0.1": rds.simulate(points[0]).steps, "table, α = 1": rds.simulate(points[1]).steps}
    for name, steps in {**compared, "DQN": curves["steps"]}.items():
        total, final = steps.sum(axis=1).mean(), steps[:, -10:].mean()
        print(f"{name:15} {total:7,.0f} steps a period, {final:5.1f} a trial at the end")
    print(f"DQN: {seconds / curves['steps'].sum() * 1e3:.1f} ms a step")


if __name__ == "__main__":
    main()
