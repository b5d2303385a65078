"""Convergence: if every action is tried often enough, a deterministic world is learned exactly."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from rl_design_space.design import (
    AdHoc,
    Constant,
    DesignPoint,
    GoalReward,
    MultiStepActions,
    QLearning,
    Task,
    Torus,
    Walled,
    World,
)
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import layouts
from tests.learning.plays import play_period

GAMMA = 0.9
REWARDS = {
    "many_rewards": GoalReward(),
    "each_success": GoalReward(step=0.0),
    "end_reward": GoalReward(step=0.0, sub_goal=0.0),
}


@cache
def optimal_values(world: World, layout: tuple[int, ...], reward: GoalReward, lengths: tuple[int, ...]) -> np.ndarray:
    """Iterate values over (counter, cell, action); the state after the final goal has value 0."""
    _, *goals = layout
    n_goals, next_cell = len(goals), world.next_cell()
    values = np.zeros((n_goals, next_cell.shape[1], 4 * len(lengths)))

    def backup(reached: int, cell: int, move: int, length: int) -> float:
        gain = 0.0
        for step in range(length):
            cell = next_cell[move, cell]
            if cell != goals[reached]:
                gain += GAMMA**step * reward.step
            elif reached == n_goals - 1:
                return gain + GAMMA**step * reward.final_goal
            else:
                gain += GAMMA**step * reward.sub_goal
                reached += 1
        return gain + GAMMA**length * values[reached, cell].max()

    for _ in range(100):
        before = values.copy()
        for reached, cell, action in np.ndindex(values.shape):
            values[reached, cell, action] = backup(reached, cell, action % 4, lengths[action // 4])
        if np.array_equal(values, before):
            break
    return values


def walk_greedily(world: World, layout: list[int], values: np.ndarray) -> int:
    """Return the steps of the greedy primitive actions from the start to the final goal, at most 100."""
    next_cell = world.next_cell()
    cell, *goals = layout
    reached = moves = 0
    while reached < len(goals) and moves < 100:
        cell = next_cell[values[reached, cell, :4].argmax(), cell]
        reached += cell == goals[reached]
        moves += 1
    return moves


@pytest.mark.parametrize("propagation", ["none", "primitives", "all_shorter"])
@pytest.mark.parametrize("lengths", [(), (2,), (3, 2)], ids=str)
@pytest.mark.parametrize("reward", REWARDS)
@pytest.mark.parametrize("world", [Torus(size=3), Torus(size=(4, 2)), Walled(size=3)], ids=str)
def test_random_behaviour_learns_the_values_of_dynamic_programming(world, reward, lengths, propagation):
    point = DesignPoint(
        seed=5,
        world=world,
        task=Task(goals=2, trials=3000, periods=1),
        representation=AdHoc(),
        exploration=Constant(epsilon=1.0),
        msa=MultiStepActions(lengths=lengths, propagation=propagation),
        reward=REWARDS[reward],
        learner=QLearning(alpha=1.0, gamma=GAMMA, explore="all"),
    )
    layout = layouts(point.seed, world.next_cell().shape[1], 2, 1)
    expected = optimal_values(world, tuple(layout[0].tolist()), point.reward, (1, *lengths))

    learned = play_period(point, 0)[0].q.reshape(expected.shape)

    # Within the second leg the final goal's own cell is never left, so nothing is learned there.
    learned[1, layout[0, 2]] = expected[1, layout[0, 2]]
    # The first goal's cell with the counter at 0 is never entered: entering it raises the counter.
    learned[0, layout[0, 1]] = expected[0, layout[0, 1]]
    np.testing.assert_allclose(learned, expected, rtol=1e-12, atol=1e-12)
    assert walk_greedily(world, layout[0].tolist(), learned) == shortest_tours(world.next_cell(), layout)[0]
