"""The Gymnasium environment fulfils the interface of Gymnasium, and its steps are what a point describes."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import dataclass, replace

import gymnasium
import numpy as np
import pytest
from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.utils.env_checker import check_env

from rl_design_space.design import (
    AdHoc,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    GoalReward,
    MultiStepActions,
    QLearning,
    ShapedReward,
    Slip,
    Task,
    Torus,
    Walled,
    cell_count,
)
from rl_design_space.environment import ID, OrderedGoals
from rl_design_space.errors import ConfigError
from tests.command_runner import PATIENCE

RIGHT, LEFT, ABOVE, BELOW = range(4)


@dataclass(frozen=True)
class Counter:
    """An agent that observes only the success counter; the number of codes is not given."""

    def observation(self, world, goals):
        counter = np.arange(goals.shape[-1], dtype=np.int64)[:, np.newaxis]
        return np.broadcast_to(10**12 * counter, (*goals.shape, cell_count(world)))


POINTS = {
    "default": DesignPoint(),
    "direct_large": DesignPoint(representation=Direct(), task=Task(goals=8), world=Torus(size=30)),
    "distance": DesignPoint(representation=Distance()),
    "unsized": DesignPoint(representation=Counter()),
    "walled_msa": DesignPoint(world=Walled(size=(2, 3)), msa=MultiStepActions(lengths=(3, 5))),
}


@pytest.mark.parametrize("name", POINTS)
@pytest.mark.parametrize(
    "arguments", [{}, {"observation": "code", "period": 3}, {"period": None}, {"render_mode": "ansi"}], ids=str
)
def test_the_checker_of_gymnasium_passes(name: str, arguments: dict):
    # Its warnings are errors here.
    check_env(gymnasium.make(ID, point=POINTS[name], **arguments).unwrapped)


def test_it_can_be_made_by_name_alone_or_with_its_module():
    assert gymnasium.make(ID).unwrapped.point == DesignPoint()
    assert isinstance(gymnasium.make(f"rl_design_space.environment:{ID}").unwrapped, OrderedGoals)


def test_many_at_a_time():
    point = DesignPoint(msa=MultiStepActions(lengths=(4,)))
    envs = gymnasium.make_vec(ID, num_envs=2, vectorization_mode="sync", point=point)
    _, first = envs.reset(seed=7)
    assert first["period"].tolist() == [7, 8]
    _, rewards, _, _, info = envs.step(np.array([0, 4]))
    assert info["executed"].tolist() == [1, 4]
    assert [len(path) for path in info["path"]] == [1, 4]
    assert rewards.tolist() == pytest.approx([-0.1, -0.1 * (1 + 0.9 + 0.81 + 0.729)])


def test_it_survives_pickling_in_the_middle_of_an_episode():
    env = OrderedGoals()
    env.reset()
    env.step(RIGHT)
    twin = pickle.loads(pickle.dumps(env))
    assert twin.step(BELOW) == env.step(BELOW)


def corridor(goals: list[int], **choices) -> OrderedGoals:
    """Return a walled grid of 8 × 2 cells with the agent in its corner and the given goals."""
    env = OrderedGoals(DesignPoint(world=Walled(size=(8, 2)), task=Task(goals=len(goals), max_steps=9), **choices))
    env._layouts = np.array([[0, *goals]], dtype=np.int32)
    return env


LONG = MultiStepActions(lengths=(5,))
LONG_RIGHT = 4


def test_a_multi_step_action_passes_goals_and_ends_at_the_last_one():
    env = corridor([2, 4], msa=LONG)
    env.reset(options={"period": 0})
    observation, reward, terminated, truncated, info = env.step(LONG_RIGHT)
    assert (terminated, truncated, info["executed"], info["moves"], info["reached"]) == (True, False, 4, 4, 2)
    assert info["rewards"] == (-0.1, 1.0, -0.1, 10.0)
    # Ad hoc rows: counter · cells + cell.
    assert info["path"] == (0, 1, 16 + 2, 16 + 3)
    assert observation == 16 + 4
    assert reward == pytest.approx(-0.1 + 0.9 * 1 - 0.81 * 0.1 + 0.729 * 10)


def test_a_multi_step_action_may_stop_at_a_sub_goal():
    env = corridor([2, 4], msa=replace(LONG, sub_goal="stop"))
    env.reset(options={"period": 0})
    observation, reward, terminated, truncated, info = env.step(LONG_RIGHT)
    assert (terminated, truncated, info["executed"], info["reached"]) == (False, False, 2, 1)
    assert observation == 16 + 2
    assert reward == pytest.approx(-0.1 + 0.9 * 1)


def test_the_printed_reward_has_one_term_more_and_the_first_reward_throughout():
    env = corridor([2, 4], msa=replace(LONG, reward="printed"))
    env.reset(options={"period": 0})
    assert env.step(LONG_RIGHT)[1] == pytest.approx(-0.1 * (1 + 0.9 + 0.81 + 0.729 + 0.6561))
    # A primitive action gets the reward received.
    env.reset()
    env.step(RIGHT)
    assert env.step(RIGHT)[1] == 1.0


def test_the_step_cap_counts_steps_and_ends_a_multi_step_action():
    env = corridor([2, 15], msa=LONG)
    env.reset(options={"period": 0})
    env.step(LONG_RIGHT)
    *_, truncated, info = env.step(LONG_RIGHT)
    assert (truncated, info["executed"], info["moves"]) == (True, 4, 9)
    with pytest.raises(ResetNeeded):
        env.step(RIGHT)
    env.reset()
    env.step(RIGHT)


@pytest.mark.parametrize(("reading", "expected"), [("step_reward", -0.1), ("zero", 0.0)])
def test_a_goal_that_is_not_due(reading: str, expected: float):
    env = corridor([2, 1], learner=QLearning(out_of_order=reading))
    env.reset(options={"period": 0})
    assert env.step(RIGHT)[1] == expected
    assert env.step(RIGHT)[1] == 1.0
    assert env.step(RIGHT)[1] == -0.1
    # A goal that was reached is no longer due.
    assert env.step(LEFT)[1] == expected


def test_rewards_are_those_of_the_point():
    env = corridor([1, 2], reward=GoalReward(step=-3.0, sub_goal=5.0, final_goal=7.0))
    env.reset(options={"period": 0})
    assert [env.step(move)[1] for move in (LEFT, RIGHT, RIGHT)] == [-3.0, 5.0, 7.0]


def test_a_code_means_the_same_in_every_layout():
    codes = OrderedGoals(DesignPoint(representation=AdHoc()), period=None, observation="code")
    for _ in range(5):
        observation, info = codes.reset()
        assert observation == info["code"] == codes.layout[0]
    assert codes.observation_space.n == 300
    direction = DesignPoint(representation=Direction())
    assert OrderedGoals(direction, observation="code").observation_space.n == 375
    assert OrderedGoals(direction).observation_space.n == 3 * cell_count(direction.world)


def test_the_grid_as_text():
    env = corridor([2, 13])
    env.render_mode = "ansi"
    env.reset(options={"period": 0})
    for move in (RIGHT, RIGHT, BELOW):
        env.step(move)
    assert env.render() == (
        "S . * . . . . .\n"
        ". . A . . 2 . .\n"
        "goal 2 of 2 is due; steps: 3, at least 6 needed"
    )  # fmt: skip
    for _ in range(3):
        env.step(RIGHT)
    assert env.render().splitlines()[1:] == [". . . . . A . .", "all goals reached; steps: 6, at least 6 needed"]
    assert OrderedGoals().render() is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"period": 500}, 'period=500: should be a whole number from 0 to 499, "seed" or None'),
        ({"period": "seeds"}, "period=seeds: should be a whole number"),
        ({"period": -1}, "period=-1: should be"),
        ({"period": True}, "period=true: should be"),
        ({"period": 1.0}, "period=1.0: should be"),
        ({"observation": "rows"}, "rows: no such observation; did you mean row?"),
        ({"point": ["world=torus"]}, r"point=\[world=torus\]: should be a DesignPoint"),
        ({"render_mode": "human"}, "human: no such render mode"),
    ],
    ids=str,
)
def test_an_invalid_argument_is_refused(arguments: dict, message: str):
    with pytest.raises(ConfigError, match=message):
        OrderedGoals(**arguments)


def test_an_invalid_option_of_reset_is_refused():
    env = OrderedGoals()
    with pytest.raises(ConfigError, match="periods: no such option of reset; did you mean period"):
        env.reset(options={"periods": 3})
    with pytest.raises(ConfigError, match="period=500"):
        env.reset(options={"period": 500})


def test_an_invalid_action_is_refused():
    env = OrderedGoals()
    with pytest.raises(ResetNeeded):
        env.step(RIGHT)
    env.reset(seed=0)
    for action in (4, -1, 1.0):
        with pytest.raises(InvalidAction, match=f"action {action}: should be a whole number from 0 to 3"):
            env.step(action)
    # None of them was a step, and any kind of whole number is an action.
    other = OrderedGoals()
    other.reset(seed=0)
    assert env.step(np.int64(RIGHT)) == other.step(RIGHT)


def test_without_gymnasium_the_error_names_the_package_to_install():
    program = "import sys; sys.modules['gymnasium'] = None; import rl_design_space.environment"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "rl_design_space.errors.ConfigError: "
        "rl_design_space.environment: needs Gymnasium; pip install 'rl-design-space[gym]'"
    )


def test_chance_draws_from_the_seeded_generator_of_the_environment():
    point = DesignPoint(world=Slip(size=6, p=0.4, astray="stays"), task=Task(goals=1, max_steps=300, periods=3))
    env = OrderedGoals(point, period=1)
    cells = []
    for _ in range(2):
        env.reset(seed=7)
        ended, went = False, []
        while not ended:
            *_, terminated, truncated, info = env.step(len(went) % 4)
            ended = terminated or truncated
            went.append(env._cell)
        cells.append(went)
    assert cells[0] == cells[1]
    straight = point.world.next_cell()
    before = [env.layout[0], *went[:-1]]
    stayed = np.mean([went[at] != straight[at % 4, before[at]] for at in range(len(went))])
    assert len(went) > 30
    assert stayed == pytest.approx(0.4, abs=4 * np.sqrt(0.24 / len(went)))
    assert info["optimum"] == pytest.approx(fewest_without_slips(env) / 0.6)


def fewest_without_slips(env: OrderedGoals) -> float:
    """Return the fewest steps in the world without slips."""
    x, y = env.point.world.offset(np.array(env.layout[1:]))
    return float(abs(x[0, env.layout[0]]) + abs(y[0, env.layout[0]]))


def test_shaped_rewards_of_an_action_of_several_steps_add_up():
    """Over k steps they add up to γ^k·Φ(s') - Φ(s), with no potential after the final goal."""
    msa = MultiStepActions(lengths=(3,))
    plain = DesignPoint(world=Torus(size=5), msa=msa, task=Task(goals=2, periods=2))
    shaped = replace(plain, reward=ShapedReward(shaping="all_goals"))
    envs = [OrderedGoals(point, period=1) for point in (plain, shaped)]
    height = shaped.reward.potential(shaped.world, np.array(envs[0].layout[1:]))
    random = np.random.default_rng(0)
    for env in envs:
        env.reset()
    ended = False
    while not ended:
        before = height[envs[1]._counter, envs[1]._cell]
        action = int(random.integers(8))
        (_, gain, terminated, _, info), (_, more, ended, truncated, _) = (env.step(action) for env in envs)
        after = 0.0 if terminated else height[envs[1]._counter, envs[1]._cell]
        assert more - gain == pytest.approx(0.9 ** info["executed"] * after - before)
        ended |= truncated
    assert terminated
