"""Which layouts the Gymnasium environment shows: those of a period, of a seed, or drawn."""

from __future__ import annotations

from rl_design_space.design import DesignPoint, Task
from rl_design_space.environment import OrderedGoals
from tests.reference_streams import layout_of


def test_the_layout_stays_until_another_is_chosen():
    env = OrderedGoals(period=3)
    layouts = [env.layout]
    for options in ({}, {"period": 7}, None, {"period": 3}):
        _, info = env.reset(options=options)
        layouts.append(env.layout)
    assert layouts == [tuple(layout_of(env.point, period)) for period in (3, 3, 7, 7, 3)]
    assert info["period"] == 3


def test_a_seed_chooses_the_layout_which_stays_until_the_next_seed():
    env = OrderedGoals(DesignPoint(task=Task(periods=20)))
    periods = [env.reset(seed=seed)[1]["period"] for seed in (3, None, None, 23, 4, None, 3)]
    assert periods == [3, 3, 3, 3, 4, 4, 3]
    assert env.layout == tuple(layout_of(env.point, 3))
    assert env.reset(seed=5, options={"period": 9})[1]["period"] == env.reset()[1]["period"] == 9
    fixed = OrderedGoals(period=3)
    assert [fixed.reset(seed=seed)[1]["period"] for seed in (1, 2, None)] == [3, 3, 3]


def test_without_any_seed_a_layout_is_drawn():
    first = [OrderedGoals().reset()[1]["period"] for _ in range(8)]
    assert len(set(first)) > 1  # one of 500: the odds against it are 10^18 to 1
    env = OrderedGoals()
    assert len({env.reset()[1]["period"] for _ in range(8)}) == 1


def test_layouts_may_be_drawn_at_every_reset():
    env = OrderedGoals(DesignPoint(task=Task(periods=20)), period=None)

    def drawn(seed: int) -> list[int]:
        return [env.reset(seed=seed if first else None)[1]["period"] for first in (True, *[False] * 40)]

    periods = drawn(1)
    assert len(set(periods)) > 10
    assert periods == drawn(1) != drawn(2)
    assert env.reset(options={"period": 19})[1]["period"] == 19
