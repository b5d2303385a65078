"""The job that everybody does: tabular Q-learning on a torus with goals to be reached in their order.

It is written down apart from the package, in plain numbers, so that a peer needs nothing but NumPy to know it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class Job:
    """The paper's default task with the ad hoc representation and linear ε = max(epsilon_start - epsilon_k·τ, 0).

    One-step Q-learning, Q = 0 at the start of a period. The agent observes its cell and how many goals it has
    reached. With probability ε it takes any action but the greedy one; among equal maxima the greedy action is
    drawn at random. A goal that is not due yields the ordinary step reward. A trial ends at the final goal, where
    the target is the reward alone, or after `max_steps` moves, where the last state is not terminal.
    """

    side: int = 10
    goals: int = 3
    trials: int = 100
    max_steps: int = 10_000
    epsilon_start: float = 0.9
    epsilon_k: float = 0.03
    alpha: float = 0.1
    gamma: float = 0.9
    step_reward: float = -0.1
    sub_goal_reward: float = 1.0
    final_goal_reward: float = 10.0

    @property
    def cells(self) -> int:
        """Cells of the world, numbered row by row."""
        return self.side * self.side

    @property
    def states(self) -> int:
        """Observations of a period; state = goals reached · cells + cell."""
        return self.goals * self.cells

    def epsilon(self) -> NDArray[np.float64]:
        """(trials,) probability of an exploratory action."""
        epsilon: NDArray[np.float64] = np.maximum(self.epsilon_start - self.epsilon_k * np.arange(self.trials), 0.0)
        return epsilon

    def next_cell(self) -> NDArray[np.int32]:
        """(4, cells) the cell that a move right, left, up or down leads to."""
        y, x = np.divmod(np.arange(self.cells, dtype=np.int32), self.side)
        moved = [(x + 1, y), (x - 1, y), (x, y - 1), (x, y + 1)]
        return np.array([to_y % self.side * self.side + to_x % self.side for to_x, to_y in moved], dtype=np.int32)
