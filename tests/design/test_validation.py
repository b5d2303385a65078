"""Every bad value is refused where an option is built, with a message that names the field."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, fields

import pytest
from pydantic import ValidationError

from rl_design_space.design import (
    AdHoc,
    Constant,
    DesignPoint,
    Direct,
    Direction,
    Distance,
    Exponential,
    GoalReward,
    Linear,
    MultiStepActions,
    QLearning,
    Sigmoidal,
    Task,
    Torus,
    Walled,
)

OPTIONS = [
    *(AdHoc, Constant, DesignPoint, Direct, Direction, Distance, Exponential, GoalReward, Linear),
    *(MultiStepActions, QLearning, Sigmoidal, Task, Torus, Walled),
]

NO_NUMBER = (math.nan, math.inf, -math.inf, "0.5", None, True)
NO_COUNT = (0, -1, 2.0, "3", None, True)
NO_CHOICE = ("", "Random", None, 1)

REFUSED = [
    (Task, "goals", NO_COUNT),
    (Task, "trials", NO_COUNT),
    (Task, "periods", NO_COUNT),
    (Task, "max_steps", (*NO_COUNT, 2**31)),
    (Torus, "size", (1, 0, -3, 3.0, "10", True, None, (), (3,), (3, 1), (3, 3, 3), (3, True), [3, 4.0], {3, 4})),
    (Walled, "size", (1, (1, 5))),
    (Distance, "goals", NO_CHOICE),
    (Direction, "goals", NO_CHOICE),
    (Direction, "rule", NO_CHOICE),
    (Constant, "epsilon", (*NO_NUMBER, -0.01, 1.01)),
    (Linear, "start", (*NO_NUMBER, -0.01, 1.01)),
    (Linear, "k", (*NO_NUMBER, -0.01)),
    (Linear, "first_trial", (-1, 0.0, True, None)),
    (Exponential, "start", (*NO_NUMBER, -0.01, 1.01)),
    (Exponential, "l", (*NO_NUMBER, 0.0, -2.0)),
    (Exponential, "first_trial", (-1, 0.0)),
    (Sigmoidal, "p", (*NO_NUMBER, 0.0, -1.0)),
    (Sigmoidal, "q", NO_NUMBER),
    (Sigmoidal, "first_trial", (-1, 0.0)),
    (MultiStepActions, "lengths", ((1,), (0,), (-2,), (3, 3), (2.0,), ("3",), (True,), 3, "3", None, (2**31,))),
    (MultiStepActions, "propagation", NO_CHOICE),
    (MultiStepActions, "reward", NO_CHOICE),
    (MultiStepActions, "sub_goal", NO_CHOICE),
    (GoalReward, "step", NO_NUMBER),
    (GoalReward, "sub_goal", NO_NUMBER),
    (GoalReward, "final_goal", NO_NUMBER),
    (QLearning, "alpha", (*NO_NUMBER, 0.0, -0.1, 1.01)),
    (QLearning, "gamma", (*NO_NUMBER, -0.1, 1.01)),
    (QLearning, "initial_q", NO_NUMBER),
    (QLearning, "explore", NO_CHOICE),
    (QLearning, "ties", NO_CHOICE),
    (QLearning, "out_of_order", NO_CHOICE),
    (QLearning, "update", NO_CHOICE),
    (DesignPoint, "seed", (-1, 2**64, 0.0, "0", True, None)),
    (DesignPoint, "task", (None, {"goals": 3}, QLearning())),
    (DesignPoint, "world", (None, 10, Task(), AdHoc())),
    (DesignPoint, "representation", (None, "ad_hoc", Torus(), AdHoc)),
    (DesignPoint, "exploration", (None, 0.1, GoalReward(), Constant)),
    (DesignPoint, "msa", (None, (3,), GoalReward())),
    (DesignPoint, "reward", (None, (0.0, 1.0, 10.0), Constant(), MultiStepActions())),
    (DesignPoint, "learner", (None, Task(), {})),
]
CASES = [
    pytest.param(option, field, value, id=f"{option.__name__}.{field}={value}")
    for option, field, values in REFUSED
    for value in values
]


@pytest.mark.parametrize(("option", "field", "value"), CASES)
def test_a_bad_value_is_refused_by_the_name_of_its_field(option: type, field: str, value: object):
    with pytest.raises(ValidationError, match=rf"(?m)^{field}\b"):
        option(**{field: value})


def test_no_field_is_left_out():
    assert {(option, field) for option, field, _ in REFUSED} == {
        (option, field.name) for option in OPTIONS for field in fields(option)
    }


@pytest.mark.parametrize("option", OPTIONS)
def test_an_unknown_field_is_refused(option: type):
    with pytest.raises(ValidationError, match="epsilonn"):
        option(epsilonn=0.1)


@pytest.mark.parametrize("option", OPTIONS)
def test_an_option_is_a_frozen_value(option: type):
    value = option()
    assert value == option()
    assert hash(value) == hash(option())
    with pytest.raises((FrozenInstanceError, ValidationError)):
        value.seed = 1


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"task": Task(goals=4), "world": Torus(size=2)}, "room for at most 3 goals"),
        ({"task": Task(goals=100)}, "room for at most 99 goals"),
        ({"task": Task(goals=3), "world": Walled(size=40_000)}, "19200000000 values"),
    ],
)
def test_goals_that_do_not_fit_the_world_are_refused(values: dict[str, object], message: str):
    with pytest.raises(ValidationError, match=message):
        DesignPoint(**values)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (Direction, r"should be built: Direction\(…\), not the class"),
        ("direction", r"should be built, .* names are for from_overrides\(\)"),
    ],
)
def test_what_is_not_built_is_refused_with_what_to_do(option: object, message: str):
    with pytest.raises(ValidationError, match=message):
        DesignPoint(representation=option)


def test_a_world_may_be_full_of_goals():
    assert DesignPoint(task=Task(goals=3), world=Torus(size=2)).task.goals == 3


@pytest.mark.parametrize(
    ("written", "canonical"),
    [
        (Constant(epsilon=1), Constant(epsilon=1.0)),
        (MultiStepActions(lengths=[3, 2]), MultiStepActions(lengths=(3, 2))),
        (Walled(size=[4, 3]), Walled(size=(4, 3))),
    ],
    ids=str,
)
def test_values_are_the_same_however_they_are_written(written: object, canonical: object):
    assert written == canonical
    assert repr(written) == repr(canonical)


def test_the_order_of_lengths_is_part_of_the_value():
    assert MultiStepActions(lengths=(3, 2)) != MultiStepActions(lengths=(2, 3))
    assert MultiStepActions(lengths=(3, 2)).action_lengths().tolist() == [1, 3, 2]
