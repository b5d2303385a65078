"""Every invalid value is refused when an option is built, with a message that names the field."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import pytest
from pydantic import ValidationError

from rl_design_space.design import (
    AdHoc,
    Constant,
    DesignPoint,
    Direction,
    GoalReward,
    Linear,
    MultiStepActions,
    QLearning,
    Task,
    Torus,
    Walled,
)
from tests.design.options import CLASSES, refused

#: In addition to the values that follow from the annotations.
ALSO_REFUSED = [
    (Task, "max_steps", (2**31,)),
    (Torus, "size", (1, 0, -3, 3.0, "10", True, (), (3,), (3, 1), (3, 3, 3), (3, True), [3, 4.0], {3, 4})),
    (Walled, "size", (1, (1, 5))),
    (MultiStepActions, "lengths", ((1,), (0,), (-2,), (3, 3), (2.0,), ("3",), (True,), 3, "3", (2**31,))),
    (DesignPoint, "seed", (-1, 2**64, 0.0, "0", True)),
    (DesignPoint, "task", ({"goals": 3}, QLearning())),
    (DesignPoint, "world", (10, Task(), AdHoc())),
    (DesignPoint, "representation", ("ad_hoc", Torus(), AdHoc)),
    (DesignPoint, "exploration", (0.1, GoalReward(), Constant)),
    (DesignPoint, "msa", ((3,), GoalReward())),
    (DesignPoint, "reward", ((0.0, 1.0, 10.0), Constant(), MultiStepActions())),
    (DesignPoint, "learner", (Task(), {})),
]
CASES = [
    *((kind, field, value) for kind in CLASSES for field, value in refused(kind)),
    *((kind, field, value) for kind, field, values in ALSO_REFUSED for value in values),
]


@pytest.mark.parametrize("kind", CLASSES)
def test_an_invalid_value_is_refused_with_the_name_of_its_field(kind: type):
    for field, value in [(field, value) for each, field, value in CASES if each is kind]:
        with pytest.raises(ValidationError, match=rf"(?m)^{field}\b"):
            kind(**{field: value})


def test_invalid_values_follow_from_the_annotations():
    values = [(field, value) for field, value in refused(Linear) if isinstance(value, (int, float, str))]
    assert {("start", -0.01), ("start", 1.01), ("k", -0.01), ("first_trial", -1), ("first_trial", 1.0)} <= set(values)
    assert ("alpha", -0.01) in refused(QLearning)
    assert ("ties", "no_such_name") in refused(QLearning)


@pytest.mark.parametrize("kind", CLASSES)
def test_an_unknown_field_is_refused(kind: type):
    with pytest.raises(ValidationError, match="epsilonn"):
        kind(epsilonn=0.1)


@pytest.mark.parametrize("kind", CLASSES)
def test_an_option_is_a_frozen_value(kind: type):
    value = kind()
    assert value == kind()
    assert hash(value) == hash(kind())
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
def test_a_class_or_a_name_is_refused_with_a_correction(option: object, message: str):
    with pytest.raises(ValidationError, match=message):
        DesignPoint(representation=option)


def test_what_a_component_lacks_is_named():
    with pytest.raises(ValidationError, match=r"instance of ActionSet; it has no behaviour\(\), labels, limits\(\)"):
        DesignPoint(msa=GoalReward())
    with pytest.raises(ValidationError, match=r"instance of Reward \["):
        DesignPoint(reward=(0.0, 1.0, 10.0))


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
def test_different_spellings_give_equal_values(written: object, canonical: object):
    assert written == canonical
    assert repr(written) == repr(canonical)


def test_the_order_of_lengths_is_part_of_the_value():
    assert MultiStepActions(lengths=(3, 2)) != MultiStepActions(lengths=(2, 3))
    assert MultiStepActions(lengths=(3, 2)).action_lengths().tolist() == [1, 3, 2]
