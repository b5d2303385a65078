"""Components with wrong tables are refused before the kernel accesses memory outside of its arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.design import AdHoc, Constant, DesignPoint, GoalReward, Task, Torus
from rl_design_space.learning import simulate, simulation
from tests.misfits import misfit

POINT = DesignPoint(task=Task(goals=2, trials=10, periods=2, max_steps=20), world=Torus(size=4))


def schedule(epsilon: np.ndarray) -> object:
    return misfit(Constant(), schedule=lambda self, trials: epsilon)


def world(next_cell: np.ndarray) -> object:
    return misfit(Torus(size=4), next_cell=lambda self: next_cell)


def codes(n_goals: int = 2, cells: int = 16, dtype: type = np.int64) -> object:
    def zeros(self, world, goals):
        return np.zeros((*goals.shape[:-1], n_goals, cells), dtype=dtype)

    return misfit(AdHoc(), observation=zeros)


def reward(*table: float) -> object:
    return misfit(GoalReward(), table=lambda self: np.array(table))


MOVES = Torus(size=4).next_cell()
MISFITS = {
    "one epsilon too few": {"exploration": schedule(np.full(9, 0.1))},
    "one epsilon too many": {"exploration": schedule(np.full(11, 0.1))},
    "epsilon above one": {"exploration": schedule(np.full(10, 1.5))},
    "epsilon below zero": {"exploration": schedule(np.full(10, -0.1))},
    "epsilon is no number": {"exploration": schedule(np.full(10, np.nan))},
    "a cell below zero": {"world": world(MOVES - np.int32(1))},
    "a cell too high": {"world": world(MOVES + np.int32(1))},
    "three moves": {"world": world(MOVES[:3])},
    "moves in floats": {"world": world(MOVES.astype(float))},
    "codes in floats": {"representation": codes(dtype=np.float64)},
    "a cell too many": {"representation": codes(cells=17)},
    "a goal too few": {"representation": codes(n_goals=1)},
    "a reward is no number": {"reward": reward(np.nan, 1.0, 10.0)},
    "four rewards": {"reward": reward(-0.1, 1.0, 10.0, 10.0)},
}


@pytest.fixture
def _no_learning(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the kernel fail, because with these tables it would read and write anywhere."""

    def learn(next_cell, lengths, threshold, rules, observation, *others):
        assert len(observation) == 0, "a table that does not fit has reached the learner"

    monkeypatch.setattr(simulation, "learn", learn)


@pytest.mark.usefixtures("_no_learning")
@pytest.mark.parametrize("name", MISFITS)
def test_a_wrong_table_is_refused_by_name(name: str):
    point = replace(POINT, **MISFITS[name])
    with pytest.raises(ValueError, match="|".join([*MISFITS[name], "schedule", "next_cell", "table"])):
        simulate(point, threads=1)


def test_a_goal_out_of_reach_is_refused():
    nobody_moves = np.tile(np.arange(16, dtype=np.int32), (4, 1))
    with pytest.raises(ValueError, match="no way leads through"):
        simulate(replace(POINT, world=world(nobody_moves)), threads=1)
