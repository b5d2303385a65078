"""Looking inside periods: replays take the kernel's steps, and what they keep follows from their paths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.design import (
    Controllers,
    DesignPoint,
    Direction,
    Linear,
    MultiStepActions,
    QLearning,
    Task,
    Torus,
    Walled,
    cell_count,
)
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.learning.replay import Replay, Replayer, available_memory
from rl_design_space.learning.tables import learning_tables

POINT = DesignPoint(
    seed=7,
    task=Task(goals=2, trials=20, periods=13, max_steps=300),
    world=Torus(size=6),
    representation=Direction(goals="all"),
    exploration=Linear(k=0.05),
)
WITH_ACTIONS = replace(POINT, world=Walled(size=(7, 5)), msa=MultiStepActions(lengths=(3,)))
#: Six actions, as the other tests of tables have.
THAT_SEE = replace(POINT, msa=Controllers(propagation="consistent"), learner=QLearning(explore="all"))
POINTS = {"primitive": POINT, "multi_step": WITH_ACTIONS, "controllers": THAT_SEE}


@pytest.fixture(params=POINTS, name="point")
def _point(request: pytest.FixtureRequest) -> DesignPoint:
    return POINTS[request.param]


def test_what_is_kept_does_not_change_the_curves(point: DesignPoint):
    plain, kept = simulate(point), simulate(point, keep=["q", "history", "visits", "paths"])
    np.testing.assert_array_equal(kept.steps, plain.steps)
    assert not plain.inside
    assert list(kept.inside) == list(range(13))
    for period, inside in kept.inside.items():
        np.testing.assert_array_equal(inside.steps, plain.steps[period])
        np.testing.assert_array_equal(inside.success, plain.success[period])
        assert inside.optimum == plain.optimum[period]
        assert plain.rows[period].tolist() == [len(inside.q), (inside.q != 0).any(axis=1).sum()]


def test_paths_obey_the_world_and_visits_count_them(point: DesignPoint):
    inside = Replayer(point)(4)
    next_cell = np.vstack([point.world.next_cell(), np.arange(cell_count(point.world))])
    goals = (*inside.goals, -1)
    visits = np.zeros_like(inside.visits)
    for path, steps, success in zip(inside.paths, inside.steps, inside.success, strict=True):
        assert len(path.actions) == len(path.explored) == len(path.cells) - 1 == steps
        assert (path.cells[0], path.counters[0]) == (inside.start, 0)
        made = inside.made[path.actions, path.counters[:-1], path.cells[:-1]]
        np.testing.assert_array_equal(path.cells[1:], next_cell[made, path.cells[:-1]])
        due = np.take(goals, path.counters[:-1])
        np.testing.assert_array_equal(np.diff(path.counters), path.cells[1:] == due)
        assert success == (path.counters[-1] == point.task.goals)
        states = path.counters < point.task.goals
        np.add.at(visits, (path.counters[states], path.cells[states]), 1)
    np.testing.assert_array_equal(inside.visits, visits)
    np.testing.assert_array_equal(inside.history[-1], inside.q)


def relearned(inside: Replay) -> np.ndarray:
    """Return the Q-matrix after each trial that textbook Q-learning has along the paths."""
    rules, history = learning_tables(inside.point).rules, []
    q = np.zeros_like(inside.q)
    for path in inside.paths:
        for at, action in enumerate(path.actions):
            counter, cell = path.counters[at], path.cells[at]
            final = path.counters[at + 1] == len(inside.goals)
            reached = path.counters[at + 1] > counter
            other_goal = not reached and path.cells[at + 1] in inside.goals
            reward = rules.step_reward if not other_goal else rules.out_of_order_reward
            if reached:
                reward = rules.final_goal_reward if final else rules.sub_goal_reward
            best = 0.0 if final else q[inside.row[path.counters[at + 1], path.cells[at + 1]]].max()
            old = q[inside.row[counter, cell], action]
            q[inside.row[counter, cell], action] = old + rules.alpha * (reward + rules.gamma * best - old)
        history.append(q.copy())
    return np.array(history)


def test_the_matrix_is_what_q_learning_has_along_the_path():
    inside = Replayer(POINT)(4)
    np.testing.assert_array_equal(inside.history, relearned(inside))


def test_exploratory_actions_are_as_frequent_as_the_schedule_says():
    inside = Replayer(replace(POINT, exploration=Linear(start=0.5, k=0.0)))(0, ["paths"])
    explored = np.concatenate([path.explored for path in inside.paths])
    assert abs(explored.mean() - 0.5) < 4 * 0.5 / np.sqrt(len(explored))


def test_only_what_is_asked_for_is_kept():
    curves = simulate(POINT, keep=["visits"], periods=[3, 5])
    assert list(curves.inside) == [3, 5]
    inside = curves.inside[5]
    assert (inside.q, inside.history, inside.paths) == (None, None, None)
    assert inside.visits.sum() == inside.steps.sum() + inside.steps.size - inside.success.sum()
    assert repr(inside).endswith("kept: visits")


def test_states_of_one_row_have_one_code():
    inside = Replayer(POINT)(2, [])
    pairs = {(code, row) for code, row in zip(inside.codes.ravel().tolist(), inside.row.ravel().tolist(), strict=True)}
    assert len(pairs) == len(np.unique(inside.codes)) == inside.row.max() + 1


def test_wrong_parts_and_periods_are_refused(monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(ConfigError, match=r"visit.*visits"):
        simulate(POINT, keep=["visit"])
    with pytest.raises(ConfigError, match=r"period=13: .*from 0 to 12"):
        simulate(POINT, keep=["q"], periods=[0, 13])
    with pytest.raises(ConfigError, match="needs keep"):
        simulate(POINT, periods=[0])
    monkeypatch.setattr("rl_design_space.learning.replay.available_memory", lambda: 1000.0)
    assert available_memory() > 1000
    with pytest.raises(ConfigError, match=r"keep: this needs .* GB"):
        Replayer(POINT)(0)
