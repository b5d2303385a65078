"""User components are checked when points are planned; built-in ones are not called."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from rl_design_space.design import (
    AdHoc,
    Constant,
    DesignPoint,
    Direction,
    GoalReward,
    MultiStepActions,
    OwnLearner,
    SuccessDriven,
    Task,
    Torus,
    Walled,
    encode,
)
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.component_check import ComponentCheck
from tests.misfits import misfit

TASK = Task(goals=2, trials=10, periods=2, max_steps=200)
MOVES = Walled(size=4).next_cell()
HERE = np.arange(16, dtype=np.int32)


def point(**choices: object) -> DesignPoint:
    return DesignPoint(**{"task": TASK, "world": Walled(size=4), **choices})


def world(next_cell: np.ndarray, *open_cells: int, **members: object) -> DesignPoint:
    obstacles = {"open_cells": lambda self: np.array(open_cells, dtype=np.int32)} if open_cells else {}
    return point(world=misfit(Walled(size=4), next_cell=lambda self: next_cell, **obstacles, **members))


def codes(change) -> DesignPoint:
    observe = AdHoc().observation
    return point(representation=misfit(AdHoc(), observation=lambda self, *given: change(observe(*given))))


def walled_off(cell: int, *, outwards: bool = False) -> np.ndarray:
    """Return the moves of a world with a cell that cannot be entered, or cannot be left."""
    moves = MOVES.copy()
    if outwards:
        moves[:, cell] = cell
    else:
        moves = np.where(moves == cell, HERE, moves)
    return moves


MISFITS = {
    "float codes": (
        codes(lambda found: found * 1.0),
        r"representation: tests\.misfits\.Misfit\.observation\(\) should give int64 of shape \(2, 2, 16\), not float64",
    ),
    "codes without counter": (codes(lambda found: found[..., 0, :]), r"int64 of shape \(2, 16\)"),
    "negative codes": (codes(lambda found: found - 1), "all at least 0; it gives -1"),
    "a list of codes": (codes(lambda found: found.tolist()), "not list"),
    "one move too few": (world(MOVES[:3]), r"Misfit\.next_cell\(\) should give int32 of shape \(4, 16\), not int32 of"),
    "moves in floats": (world(MOVES * 1.0), "not float64"),
    "a way out": (world(MOVES + np.int32(1)), "all from 0 to 15; it gives 1 to 16"),
    "a cell that cannot be entered": (
        world(walled_off(6)),
        r"world: .*next_cell\(\) leaves no way from \(x=0, y=0\) to \(x=2, y=1\), so a goal there could not be reached",
    ),
    "a cell that cannot be left": (world(walled_off(6, outwards=True)), r"no way from \(x=2, y=1\) to \(x=0, y=0\)"),
    "too few open cells": (world(MOVES, 0, 1), r"task\.goals=2: .*has only 2 open ones"),
    "open cells twice": (world(MOVES, 0, 1, 1, 2), "each cell once, in ascending order"),
    "open cells outside": (world(MOVES, 0, 1, 16), "all from 0 to 15; it gives 0 to 16"),
    "open cells as a list": (
        point(world=misfit(Walled(size=4), open_cells=lambda self: [0, 1, 2])),
        r"open_cells\(\) should give int32 of shape \(16,\), not list",
    ),
    "a schedule too short": (
        point(exploration=misfit(Constant(), schedule=lambda self, trials: np.zeros(trials - 1))),
        r"exploration: .*schedule\(\) should give float64 of shape \(10,\), not float64 of shape \(9,\)",
    ),
    "ε above one": (
        point(exploration=misfit(Constant(), schedule=lambda self, trials: np.full(trials, 2.0))),
        "all from 0 to 1; it gives 2.0 to 2.0",
    ),
    "four rewards": (point(reward=misfit(GoalReward(), table=lambda self: np.zeros(4))), r"reward: .*shape \(3,\)"),
    "lengths that do not begin with 1": (
        point(msa=misfit(MultiStepActions(lengths=(2,)), action_lengths=lambda self: np.array([2, 1], dtype=np.int32))),
        "begin with 1",
    ),
    "digits that the base has no room for": (
        point(representation=misfit(AdHoc(), observation=lambda self, *_: encode(np.full((2, 2, 16), 3), base=3))),
        r"representation: .*observation\(\) calls encode\(digits, base=3\): digits should be from 0 to 2, but",
    ),
    "more lengths than it says": (
        point(msa=misfit(MultiStepActions(), action_lengths=lambda self: np.array([1, 2], dtype=np.int32))),
        r"msa: .*shape \(1,\), not int32 of shape \(2,\)",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MISFITS)
def test_a_broken_contract_is_explained_by_class_expectation_and_result(name: str):
    given, message = MISFITS[name]
    with pytest.raises(ConfigError, match=message):
        ComponentCheck()(given)


@pytest.mark.parametrize("name", [name for name in MISFITS if not name.startswith("a cell that")])
def test_simulate_explains_a_broken_contract_as_planning_does(name: str):
    given, message = MISFITS[name]
    with pytest.raises(ConfigError, match=message):
        simulate(given, threads=1)


def test_a_component_that_raises_does_not_fail_planning():
    def broken(self, trials):
        raise ArithmeticError("no luck")

    ComponentCheck()(point(exploration=misfit(Constant(), schedule=broken)))


@dataclass(frozen=True)
class Listed(Constant):
    levels: list[float] = field(default_factory=list)


DRAWN = np.random.default_rng(0)


@dataclass(frozen=True)
class Lucky:
    """Rewards that are drawn when it is built."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "drawn", DRAWN.random(3))

    def table(self) -> np.ndarray:
        return self.drawn


@dataclass(frozen=True)
class Grown:
    """Rewards that grow when it is built again from its own field, which is no draw."""

    goal: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "goal", self.goal + 1)

    def table(self) -> np.ndarray:
        return np.array([-self.goal, self.goal, self.goal])


AGAIN = "gives other values at a second call; results are found by the fields of a component, so it must not draw"
#: What draws random numbers, and the beginning of the message.
DRAWING = {
    "a representation": (
        codes(lambda found: found + DRAWN.integers(99)),
        r"representation: .*Misfit\.observation\(\) in Walled",
    ),
    "a world": (
        point(world=misfit(Walled(size=4), next_cell=lambda self: np.roll(MOVES, DRAWN.integers(1, 4), axis=0))),
        r"world: .*Misfit\.next_cell\(\)",
    ),
    "obstacles": (
        point(world=misfit(Walled(size=4), open_cells=lambda self: np.sort(DRAWN.permutation(HERE)[:8]))),
        r"world: .*\.open_cells\(\)",
    ),
    "offsets": (
        point(
            world=misfit(
                Walled(size=4), offset=lambda self, goals: 2 * (DRAWN.integers(2, size=(*goals.shape, 16), dtype="i4"),)
            ),
            representation=Direction(),
        ),
        r"representation: Direction\.observation\(\) in .*Misfit",
    ),
    "a schedule": (
        point(exploration=misfit(Constant(), schedule=lambda self, trials: DRAWN.random(trials))),
        r"exploration: .*\.schedule\(\)",
    ),
    "rewards": (point(reward=misfit(GoalReward(), table=lambda self: DRAWN.random(3))), r"reward: .*\.table\(\)"),
    "an instance": (
        point(reward=Lucky()),
        r"reward: .*\.table\(\)",
    ),
    "a counter": (
        point(reward=misfit(GoalReward(), seen=np.zeros(3), table=lambda self: np.add(self.seen, 1, out=self.seen))),
        r"reward: .*\.table\(\)",
    ),
}


@pytest.mark.parametrize("name", DRAWING)
def test_a_component_that_draws_random_numbers_is_refused(name: str):
    given, message = DRAWING[name]
    with pytest.raises(ConfigError, match=f"{message} {AGAIN}"):
        ComponentCheck()(given)


def test_a_component_may_compute_a_field_from_itself():
    ComponentCheck()(point(reward=Grown()))


def test_an_unhashable_component_is_refused():
    with pytest.raises(
        ConfigError, match=r"test_component_check\.Listed: should be a frozen dataclass of hashable values"
    ):
        ComponentCheck()(point(exploration=Listed()))


def test_each_combination_of_user_components_is_checked_once():
    calls = []

    def counted(self, trials):
        calls.append(trials)
        return np.zeros(trials)

    own = misfit(Constant(), schedule=counted)
    check = ComponentCheck()
    for seed in range(3):
        check(point(exploration=own, seed=seed))
    check(DesignPoint(task=Task(trials=7), exploration=own))
    assert calls == [10, 10, 7, 7]  # twice, to see that it draws no random numbers


def test_built_in_components_are_not_checked(monkeypatch: pytest.MonkeyPatch):
    tried = []
    monkeypatch.setattr(Torus, "next_cell", tried.append)
    monkeypatch.setattr(Constant, "schedule", lambda *given: tried.append(given))
    ComponentCheck()(DesignPoint())
    assert tried == []


# Other worlds.


def test_starts_and_goals_lie_on_open_cells():
    door = np.where(np.isin(MOVES, [1, 5, 9]), HERE, MOVES)  # a wall with its door at the bottom
    free = [cell for cell in range(16) if cell not in (1, 5, 9)]
    given = world(door, *free)
    ComponentCheck()(given)
    curves = simulate(given, threads=1)
    assert curves.optimum.min() >= 1
    assert curves.success.any()


def test_a_world_with_all_cells_open_has_the_layouts_of_a_world_without_obstacles():
    plain, opened = simulate(point(), threads=1), simulate(world(MOVES, *range(16)), threads=1)
    np.testing.assert_array_equal(plain.steps, opened.steps)
    np.testing.assert_array_equal(plain.optimum, opened.optimum)


def test_a_ring_with_a_single_direction_can_be_learned():
    ring = np.tile(np.roll(HERE, -1), (4, 1))  # every move leads on to the next cell
    given = world(ring)
    ComponentCheck()(given)
    curves = simulate(given, threads=1)
    np.testing.assert_array_equal(curves.steps, np.broadcast_to(curves.optimum[:, np.newaxis], curves.steps.shape))


@dataclass(frozen=True, kw_only=True)
class Unfit(OwnLearner):
    """A learner that cannot be compiled."""

    @staticmethod
    def update(step, q, memory, parameters):
        return {"no": object()}[step]


@dataclass(frozen=True, kw_only=True)
class Bound(OwnLearner):
    """A learner whose update is a method."""

    def update(self, step, q, memory, parameters):
        return 0.0


@dataclass(frozen=True, kw_only=True)
class Short(SuccessDriven):
    """A closed loop whose rule takes too few arguments."""

    @staticmethod
    def rule(counters):
        return 0.5


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        ({"learner": Unfit()}, r"learner: .*Unfit.update\(\): cannot be compiled by Numba: "),
        (
            {"learner": Bound()},
            r"learner: .*Bound.update\(\): takes \(self, step, q, memory, parameters\); should be a static method of "
            r"\(step, q, memory, parameters\)",
        ),
        (
            {"exploration": Short()},
            r"exploration: .*Short.rule\(\): takes \(counters\); should be a static method of \(counters, parameters\)",
        ),
    ],
    ids=["compiled", "bound", "short"],
)
def test_functions_that_learning_compiles_are_compiled_when_they_are_planned(choices: dict, message: str):
    with pytest.raises(ConfigError, match=message):
        ComponentCheck()(point(**choices))
