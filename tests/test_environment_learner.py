"""A learner that learns through the Gymnasium environment, step by step, gets the results of the kernel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import DesignPoint, Direction, MultiStepActions, Task, Walled
from rl_design_space.environment import OrderedGoals
from rl_design_space.learning import simulate
from tests import reference
from tests.learning import strategies
from tests.learning.plays import play_period
from tests.misfits import misfit
from tests.reference_streams import generator_of, layout_of


def by_observation(env: OrderedGoals, actions: list[reference.Action], period: int) -> list[reference.Action]:
    """Return actions whose controls are found by the observations of the env instead of codes."""
    env.reset(options={"period": period})
    codes, seen = np.ravel(env._codes).tolist(), np.ravel(env._observations).tolist()
    return [
        replace(action, at={o: action.at[c] for c, o in zip(codes, seen, strict=True) if c in action.at})
        for action in actions
    ]


def learn_through(env: OrderedGoals, period: int) -> reference.Period:
    """Learn all trials of a period with the plain learner, from the random words of the kernel and the env alone."""
    point = env.point
    actions = by_observation(env, reference.actions_of(point, layout_of(point, period)[1:]), period)
    assert env.action_space.n == len(actions)
    q: dict[int, list[float]] = {}
    code_of: dict[int, int] = {}

    def see(observation: int, info: dict) -> int:
        assert env.observation_space.contains(observation)
        assert code_of.setdefault(observation, info["code"]) == info["code"]
        q.setdefault(observation, [point.learner.initial_q] * len(actions))
        return observation

    generator = generator_of(point, period)
    result = reference.Period([], [], {})
    for epsilon in point.exploration.schedule(point.task.trials).tolist():
        state = see(*env.reset(options={"period": period}))
        ended = False
        reached = 0
        while not ended:
            action = reference.choose(q[state], epsilon, generator.next_word(), point.learner)
            observation, reward, terminated, truncated, info = env.step(action)
            for seen in info["path"]:
                q.setdefault(seen, [point.learner.initial_q] * len(actions))
            following = None if terminated else see(observation, info)
            reference.update(point, q, state, action, reward, info["executed"], following)
            states = [*info["path"], following]
            stopped = point.msa.sub_goal == "stop" and info["reached"] > reached
            reference.propagate(point, q, actions, action, states, info["made"], info["rewards"], stopped)
            reached = info["reached"]
            assert info["path"][0] == state
            state, ended = following, terminated or truncated
        result.steps.append(info["moves"])
        result.success.append(terminated)
        assert not (terminated and truncated)
        assert terminated == (info["reached"] == point.task.goals)
    assert len(set(code_of.values())) == len(code_of)
    result.q.update({code_of[seen]: values for seen, values in q.items() if seen in code_of})
    return result


@settings(deadline=None, max_examples=60)
@given(point=strategies.points(), observation=st.sampled_from(["row", "code"]))
def test_a_learner_gets_the_results_of_the_kernel(point: DesignPoint, observation: str):
    check_learner(point, observation)


@settings(deadline=None, max_examples=25)
@given(point=strategies.tabulated_points, observation=st.sampled_from(["row", "code"]))
def test_a_learner_with_actions_that_see_gets_the_results_of_the_kernel(point: DesignPoint, observation: str):
    check_learner(point, observation)


def check_learner(point: DesignPoint, observation: str) -> None:
    curves = simulate(point, threads=1)
    env = OrderedGoals(point, observation=observation)
    for period in range(min(3, point.task.periods)):
        learned = learn_through(env, period)
        assert learned.steps == curves.steps[period].tolist()
        assert learned.success == curves.success[period].tolist()
        assert env.reset()[1]["optimum"] == curves.optimum[period]
    played, codes = play_period(point, period)
    at = {code: row for row, code in enumerate(codes.tolist())}
    for code, values in learned.q.items():
        assert played.q[at[code]].tobytes() == np.array(values).tobytes()


def test_the_default_task_gives_the_results_of_the_kernel():
    point = DesignPoint(task=Task(periods=2), representation=Direction(), msa=MultiStepActions(lengths=(3,)))
    curves = simulate(point, threads=1)
    assert learn_through(OrderedGoals(point), 1).steps == curves.steps[1].tolist()


def test_starts_and_goals_lie_where_there_are_no_obstacles():
    solid, here = [1, 5, 9], np.arange(16, dtype=np.int32)
    moves = Walled(size=4).next_cell()
    maze = misfit(
        Walled(size=4),
        next_cell=lambda self: np.where(np.isin(moves, solid), here, moves),
        open_cells=lambda self: np.setdiff1d(here, solid).astype(np.int32),
    )
    point = DesignPoint(world=maze, task=Task(goals=2, trials=5, periods=4))
    curves, env = simulate(point, threads=1), OrderedGoals(point)
    for period in range(4):
        assert learn_through(env, period).steps == curves.steps[period].tolist()
        assert not set(env.layout) & set(solid)


@settings(deadline=None, max_examples=50)
@given(point=strategies.points(), data=st.data())
def test_rows_are_those_of_the_kernel(point: DesignPoint, data: st.DataObject):
    """Rows are numbered by the first occurrence of their code over success counters and cells, as in the kernel."""
    period = data.draw(st.integers(0, point.task.periods - 1))
    env = OrderedGoals(point, period)
    _, *goals = layout_of(point, period)
    codes = point.representation.observation(point.world, np.array(goals)).ravel().tolist()
    row_of = {code: row for row, code in enumerate(dict.fromkeys(codes))}
    assert len(row_of) == simulate(point, threads=1).rows[period, 0] <= env.observation_space.n
    observation, info = env.reset()
    for action in data.draw(st.lists(st.integers(0, int(env.action_space.n) - 1), max_size=30)):
        assert observation == row_of[info["code"]]
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            observation, info = env.reset()
