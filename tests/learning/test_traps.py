"""Known mistakes, of this and of other implementations: one test each, on tables built by hand.

The learner of these tests replaces a Q-value by its target (α = 1), pays -1 a move, 4 for a due sub-goal and 8
for the due final goal, and among equals takes the first action, to the right, unless a test says otherwise.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from rl_design_space.design import (
    Constant,
    DesignPoint,
    Direction,
    Distance,
    Linear,
    MultiStepActions,
    QLearning,
    Sigmoidal,
    Task,
    Torus,
)
from rl_design_space.learning import simulate
from rl_design_space.learning.behaviour import COIN_SIDES
from rl_design_space.learning.streams import layouts
from tests.learning.plays import corridor, play, play_period, state_yielding, word_for

RIGHT, LEFT, ABOVE, BELOW = range(4)
#: The same move, repeated: action number 4 in a table of eight.
LONG_RIGHT = 4


def first_action(word: int, **rules: object) -> int:
    """Return the action that a random word selects if every step costs 1: the one whose value changes."""
    all_to_the_middle = np.ones((4, 3), dtype=np.int32)
    q = play(all_to_the_middle, [0, 2], state=state_yielding(word), max_steps=1, **rules).q
    return int(np.flatnonzero(q[0]).item())


#: Lower halves of random words, evenly spread.
WORDS = range(COIN_SIDES // 24, COIN_SIDES, COIN_SIDES // 12)


def frequencies(**rules: object) -> list[float]:
    """Return the share of each action over evenly spread random words."""
    counted = Counter(first_action(word, **rules) for word in WORDS)
    return [counted[action] / len(WORDS) for action in range(4)]


def play_long_right(cells: int, goals: list[int], length: int, **rules: object):
    """Begin at the left end of a corridor with a multi-step action to the right."""
    state = state_yielding(word_for(LONG_RIGHT, 8))
    return play(corridor(cells), [0, *goals], lengths=(1, length), epsilon=1.0, state=state, gamma=0.5, **rules)


def test_exploration_leaves_out_the_greedy_action():
    assert frequencies(epsilon=1.0, explore_all=False) == [0, 1 / 3, 1 / 3, 1 / 3]


def test_exploration_of_the_literal_reading_draws_among_all_actions():
    assert frequencies(epsilon=1.0, explore_all=True) == [1 / 4] * 4


def test_exploration_leaves_out_the_drawn_one_of_several_greedy_actions():
    rules = {"explore_all": False, "first_maximum": False}
    assert all(first_action(word, epsilon=1.0, **rules) != first_action(word, epsilon=0.0, **rules) for word in WORDS)
    assert frequencies(epsilon=1.0, **rules) == [1 / 4] * 4


def test_ties_are_drawn_among_the_maxima():
    assert frequencies(epsilon=0.0, first_maximum=False) == [1 / 4] * 4


def test_ties_of_the_other_reading_go_to_the_first_maximum():
    assert frequencies(epsilon=0.0, first_maximum=True) == [1, 0, 0, 0]


@pytest.mark.parametrize(("upper", "explores"), [(0, True), (2**29 - 1, True), (2**29, False), (2**32 - 1, False)])
def test_the_upper_half_of_a_word_decides_whether_to_explore(upper: int, explores: bool):
    word = upper * COIN_SIDES + word_for(BELOW, 4)
    assert (first_action(word, epsilon=1 / 8) == BELOW) == explores


@pytest.mark.parametrize(("out_of_order", "expected"), [(-1.0, -1.0), (0.0, 0.0)])
def test_a_goal_out_of_order_is_rewarded_like_any_step_by_default(out_of_order: float, expected: float):
    # The second goal lies before the first one.
    played = play(corridor(4), [0, 2, 1], max_steps=2, out_of_order_reward=out_of_order, gamma=0.0)
    assert played.q[0, RIGHT] == expected
    assert played.q[1, RIGHT] == 4.0


def test_a_goal_out_of_order_does_not_count():
    played = play(corridor(4), [0, 2, 1], max_steps=2)
    assert played.success == [False]


def test_a_goal_already_reached_is_out_of_order_too():
    # The first goal is the right end, where the next move to the right stays on it.
    played = play(corridor(3), [1, 2, 0], max_steps=2, out_of_order_reward=-3.0, gamma=0.0)
    at_first_goal = 3 + 2
    assert played.q[at_first_goal, RIGHT] == -3.0


@pytest.mark.parametrize(("learner", "paid"), [({}, -0.1), ({"out_of_order": "zero"}, 0.0)])
def test_a_point_rewards_a_goal_out_of_order_like_a_step_by_default(learner: dict[str, str], paid: float):
    # In a world of two by two cells all but the start hold goals; the start's neighbours are two of them.
    point = DesignPoint(
        task=Task(goals=3, trials=50, periods=1),
        world=Torus(size=2),
        exploration=Constant(epsilon=1.0),
        learner=QLearning(alpha=1.0, gamma=0.0, explore="all", **learner),
    )
    start = layouts(point.seed, 4, 3, 1)[0, 0]
    values = set(play_period(point, 0)[0].q[start].tolist())
    assert paid in values
    assert values <= {paid, 1.0}


def test_steps_are_counted_rather_than_decisions():
    assert play_long_right(4, [3], length=3).steps == [3]


def test_remaining_steps_of_an_action_that_reaches_the_final_goal_are_not_counted():
    assert play_long_right(4, [2], length=3).steps == [2]


def test_failed_trials_are_kept_at_the_cap():
    point = DesignPoint(task=Task(goals=3, trials=5, periods=20, max_steps=40))
    curves = simulate(point)
    assert curves.steps.shape == (20, 5)
    assert 0 < (~curves.success).sum() < curves.success.size
    assert (curves.steps[~curves.success] == 40).all()


def test_tau_begins_with_zero():
    assert Linear(start=0.9, k=0.1).schedule(2).tolist() == pytest.approx([0.9, 0.8])
    assert Sigmoidal(p=1.0, q=0.0).schedule(1).tolist() == [0.5]


@pytest.mark.parametrize(("size", "values"), [(10, 11), (20, 21), (9, 9), ((10, 4), 8)])
def test_distances_have_the_value_zero_too(size: int | tuple[int, int], values: int):
    codes = Distance().observation(Torus(size=size), np.array([0]))
    assert np.unique(codes).tolist() == list(range(values))


def test_the_return_of_a_multi_step_action_has_one_term_for_each_step():
    # -1 - 1/2 + 8/4, and nothing follows the final goal.
    assert play_long_right(4, [3], length=3).q[0, LONG_RIGHT] == 0.5


def test_the_printed_return_of_a_multi_step_action_has_one_more_term_of_the_first_reward():
    q = play_long_right(4, [3], length=3, printed_msa_reward=True).q
    assert q[0, LONG_RIGHT] == -(1 + 1 / 2 + 1 / 4 + 1 / 8)


def test_a_sub_goal_on_the_way_is_rewarded_at_its_step():
    # -1 + 4/2 - 1/4, then the value 0 of the cell behind.
    played = play_long_right(6, [2, 5], length=3, max_steps=3)
    assert played.q[0, LONG_RIGHT] == 0.75
    assert played.steps == [3]


def test_the_bootstrap_is_discounted_by_the_executed_steps():
    # The cap ends the action after two of five moves: -1 - 1/2 + 16/4.
    q = play_long_right(9, [8], length=5, max_steps=2, initial_q=16.0).q
    assert q[0, LONG_RIGHT] == 2.5


def test_the_bootstrap_of_an_action_stopped_at_a_sub_goal_is_discounted_by_the_executed_steps():
    # Two of five moves: -1 + 4/2 + 16/4, from the row of the sub-goal with the counter at 1.
    q = play_long_right(9, [2, 8], length=5, max_steps=3, initial_q=16.0, stop_at_sub_goal=True).q
    assert q[0, LONG_RIGHT] == 5.0


def test_stopping_at_a_sub_goal_is_a_reading():
    rules = {"max_steps": 4, "initial_q": 16.0}
    going_on = play_long_right(9, [2, 8], length=4, **rules).q
    stopping = play_long_right(9, [2, 8], length=4, **rules, stop_at_sub_goal=True).q
    assert going_on[0, LONG_RIGHT] == -1 + 4 / 2 - 1 / 4 - 1 / 8 + 16 / 16
    assert stopping[0, LONG_RIGHT] == -1 + 4 / 2 + 16 / 4


def test_only_primitive_actions_learn_from_a_multi_step_action_by_default():
    # Behind the first move the value is 0, so every primitive move to the right is worth -1 but the last one.
    q = play_long_right(4, [3], length=3, propagated_lengths=1).q
    assert q[:3, RIGHT].tolist() == [-1.0, -1.0, 8.0]
    assert q[0, LONG_RIGHT] == 0.5


def test_propagation_is_in_the_order_of_time():
    # Updated backwards, the first cell would already see the 8 behind it.
    q = play_long_right(3, [2], length=2, propagated_lengths=1).q
    assert q[0, RIGHT] == -1.0


@pytest.mark.parametrize("propagation", ["none", "primitives", "all_shorter"])
def test_the_terminal_state_is_never_updated(propagation: str):
    point = DesignPoint(
        world=Torus(size=4),
        task=Task(goals=2, trials=50, periods=1),
        msa=MultiStepActions(lengths=(2, 3), propagation=propagation),
        learner=QLearning(initial_q=3.0),
    )
    final_goal = layouts(point.seed, 16, 2, 1)[0, 2]
    q = play_period(point, 0)[0].q
    assert (q[16 + final_goal] == 3.0).all()
    assert np.count_nonzero(q != 3.0) > 100


def test_the_value_of_reaching_the_final_goal_is_its_reward():
    assert play(corridor(2), [0, 1], initial_q=100.0).q[0, RIGHT] == 8.0


def test_propagated_values_of_reaching_the_final_goal_are_its_reward():
    q = play_long_right(4, [3], length=3, initial_q=100.0, propagated_lengths=1).q
    assert q[2, RIGHT] == 8.0
    assert q[0, LONG_RIGHT] == 0.5


def test_the_state_at_the_step_cap_is_not_terminal():
    # One move, then the cap: -1 and the value of the next cell.
    played = play(corridor(5), [0, 4], max_steps=1, initial_q=16.0)
    assert (played.steps, played.success) == ([1], [False])
    assert played.q[0, RIGHT] == 15.0


def test_a_goal_reached_with_the_last_step_is_a_success():
    played = play(corridor(3), [0, 2], max_steps=2)
    assert (played.steps, played.success) == ([2], [True])


def test_layouts_do_not_differ_between_points():
    first, second = (
        simulate(DesignPoint(task=Task(trials=trials, periods=20), representation=representation))
        for trials, representation in ((1, Direction()), (4, Distance()))
    )
    assert first.optimum.tolist() == second.optimum.tolist()


@pytest.mark.parametrize(("printed", "expected"), [(False, -1 + 0.5 * 16), (True, 16 + (-1 + 0.5 * (16 - 16)))])
def test_the_standard_rule_does_not_discount_the_old_value(printed: bool, expected: float):
    q = play(corridor(5), [0, 4], max_steps=1, initial_q=16.0, gamma=0.5, printed_update=printed).q
    assert q[0, RIGHT] == expected
