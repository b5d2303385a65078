"""NumPy in lock-step: one step of all periods at a time.

Each period goes on with its next trial as soon as it has finished one, and leaves when it has finished all.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn

TITLE = "NumPy, lock-step"
PERIODS = 500


def version() -> str:
    """The tool that learns."""
    return f"NumPy {np.__version__}"


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    next_cell = job.next_cell().astype(np.int64)
    # One entry more, for those that have just finished their last trial.
    epsilon = np.append(job.epsilon(), 0.0)
    rewards = np.full(job.goals, job.sub_goal_reward)
    rewards[-1] = job.final_goal_reward

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        periods = len(layouts)
        rng = np.random.default_rng(seed)
        # After the final goal there is nothing to gain: its values stay 0.
        q = np.zeros((periods, job.goals + 1, job.cells, 4))
        starts, goals = layouts[:, 0].astype(np.int64), layouts[:, 1:]
        total = np.zeros(periods, dtype=np.int64)

        lane = np.arange(periods)  # periods still learning
        cell = starts.copy()
        reached, trial, steps = (np.zeros(periods, dtype=np.int64) for _ in range(3))
        while len(lane):
            here = np.arange(len(lane))
            values = q[lane, reached, cell]
            # Among equal maxima, the one with the largest random number.
            best = values == values.max(axis=1, keepdims=True)
            greedy = np.where(best, rng.random(values.shape), -1.0).argmax(axis=1)
            explore = rng.random(len(lane)) < epsilon[trial]
            action = np.where(explore, (greedy + rng.integers(1, 4, len(lane))) % 4, greedy)

            old = values[here, action]
            at = lane, reached, cell, action
            cell = next_cell[action, cell]
            met = cell == goals[lane, reached]
            reward = np.where(met, rewards[reached], job.step_reward)
            reached = reached + met
            steps += 1
            target = reward + job.gamma * q[lane, reached, cell].max(axis=1)
            q[at] = old + job.alpha * (target - old)

            ended = (reached == job.goals) | (steps == job.max_steps)
            if ended.any():
                total[lane[ended]] += steps[ended]
                trial[ended] += 1
                cell[ended] = starts[lane[ended]]
                reached[ended] = 0
                steps[ended] = 0
                going_on = trial < job.trials
                if not going_on.all():
                    lane, cell, reached, trial, steps = (
                        array[going_on] for array in (lane, cell, reached, trial, steps)
                    )
        return total

    return learn
