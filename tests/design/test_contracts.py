"""Every shipped option keeps its contract, and every breach of a contract is reported."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.config.compose import OPTION_GROUPS
from rl_design_space.contracts import (
    check_exploration,
    check_msa,
    check_representation,
    check_reward,
    check_study,
    check_world,
)
from rl_design_space.design import (
    AdHoc,
    Constant,
    Direction,
    Distance,
    Exponential,
    GoalReward,
    Linear,
    MultiStepActions,
    Torus,
    Walled,
)
from rl_design_space.plan.planner import Planner
from tests.command_runner import PATIENCE, python
from tests.design.options import names_of, variations
from tests.misfits import misfit

ROOT = Path(__file__).parents[2]

CHECKS = {
    "world": check_world,
    "representation": check_representation,
    "exploration": check_exploration,
    "msa": check_msa,
    "reward": check_reward,
}
SHIPPED = [pytest.param(group, name, id=f"{group}={name}") for group in CHECKS for name in names_of(group)]
#: Beside the shipped options and the limits of their ranges.
UNUSUAL = [
    (check_world, Torus(size=(100, 3))),
    (check_world, Walled(size=(2, 9))),
    (check_world, misfit(Walled(size=3), open_cells=lambda self: np.array([0, 1, 3], dtype=np.int32))),
    (check_exploration, Exponential(start=0.01, l=0.5)),
    (check_msa, MultiStepActions(lengths=(5, 2, 3))),
]


@pytest.mark.parametrize(("group", "name"), SHIPPED)
def test_a_shipped_option_keeps_its_contract(group: str, name: str, planner: Planner):
    option = getattr(planner([f"{group}={name}"]).point, group)
    CHECKS[group](option)
    for variation in variations(option):
        CHECKS[group](variation)


def test_the_variations_of_an_option_are_those_of_its_annotations():
    varied = set(variations(Direction()))
    assert varied == {
        Direction(rule=rule, goals=goals)
        for rule in ("dominant_axis", "horizontal_first")
        for goals in ("all", "remaining")
    }
    assert {Linear(start=0), Linear(start=1), Linear(k=0)} <= set(variations(Linear()))
    assert Torus(size=2) in variations(Torus())


def test_every_choice_with_a_contract_has_options_and_only_the_learner_has_no_contract():
    assert set(CHECKS) == set(OPTION_GROUPS) - {"learner"}
    assert all(names_of(group) for group in CHECKS)


@pytest.mark.parametrize(
    ("check", "component"), UNUSUAL, ids=lambda value: getattr(value, "__name__", None) or str(value)
)
def test_unusual_values_keep_the_contract(check, component):
    check(component)


def test_a_representation_can_be_checked_in_given_worlds():
    check_representation(Distance(), worlds=[Torus(size=30), Walled(size=(2, 40))])


def test_a_study_keeps_its_contract_if_it_can_be_planned():
    check_study("table4")
    with pytest.raises(AssertionError, match="study=tabel4: no such option; did you mean study=table4"):
        check_study("tabel4")


# Breaches.

calls = count()


def world(**members: object) -> object:
    return misfit(Torus(size=3), **members)


def opened(*cells: int) -> object:
    return world(open_cells=lambda self: np.array(cells, dtype=np.int32))


def representation(observation) -> object:
    return misfit(AdHoc(), observation=observation)


def schedule(epsilon) -> object:
    return misfit(Constant(epsilon=0.5), schedule=lambda self, trials: epsilon(trials))


def reward(table: object) -> object:
    return misfit(GoalReward(), table=lambda self: table)


def lengths(*table: int, dtype: type = np.int32) -> object:
    return misfit(MultiStepActions(lengths=(2, 3)), action_lengths=lambda self: np.array(table, dtype=dtype))


def ad_hoc(world, goals) -> np.ndarray:
    return AdHoc().observation(world, goals)


def shifts_its_input(self, world, goals):
    codes = ad_hoc(world, goals)
    goals += 1
    return codes


def one_layout_only(self, world, goals):
    if goals.ndim > 1:
        raise IndexError("too many dimensions")
    return ad_hoc(world, goals)


def first_layout_for_all(self, world, goals):
    first = goals.reshape(-1, goals.shape[-1])[0]
    return np.broadcast_to(Distance().observation(world, first), ad_hoc(world, goals).shape)


class NoDataclass:
    def schedule(self, trials: int) -> np.ndarray:
        return np.zeros(trials)


@dataclass
class Thawed(NoDataclass):
    pass


@dataclass(frozen=True)
class Unhashable(NoDataclass):
    steps: list[int] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class NoValue(NoDataclass):
    pass


torus, float_codes, next_cell = Torus(size=3), np.zeros((2, 3)), Torus(size=3).next_cell()
NAN = float("nan")

BROKEN = {
    "a class": (check_exploration, Constant, "must be built"),
    "another choice": (check_exploration, GoalReward(), "every member of Exploration"),
    "no dataclass": (check_exploration, NoDataclass(), "NoDataclass must be a frozen dataclass"),
    "not frozen": (check_exploration, Thawed(), "Thawed must be a frozen dataclass"),
    "not hashable": (check_exploration, Unhashable(), "Unhashable must be hashable"),
    "no equality": (check_exploration, NoValue(), "must equal a copy of itself"),
    "world: three sides": (check_world, world(shape=(3, 3, 1), reach=(1, 1)), "shape must be two whole numbers"),
    "world: no cells": (check_world, world(shape=(3, 0), reach=(1, 0)), "shape must be two whole numbers"),
    "world: reach in floats": (check_world, world(reach=(1.0, 1.0)), "reach must be two whole numbers"),
    "world: list of moves": (
        check_world,
        world(next_cell=next_cell.tolist),
        r"next_cell\(\) should give int32 of shape \(4, 9\), not list",
    ),
    "world: transposed": (
        check_world,
        world(next_cell=lambda self: next_cell.T),
        r"should give int32 of shape \(4, 9\), not int32 of shape \(9, 4\)",
    ),
    "world: 64 bits": (
        check_world,
        world(next_cell=lambda self: next_cell.astype(int)),
        "should give int32 .* not int64",
    ),
    "world: a way out": (
        check_world,
        world(next_cell=lambda self: next_cell + np.int32(1)),
        "from 0 to 8; it gives 1 to 9",
    ),
    "world: below zero": (
        check_world,
        world(next_cell=lambda self: next_cell - np.int32(1)),
        "from 0 to 8; it gives -1 to 7",
    ),
    "world: moving walls": (
        check_world,
        world(next_cell=lambda self: np.roll(next_cell, next(calls), axis=0)),
        r"next_cell\(\) must return the same values at every call",
    ),
    "world: goal elsewhere": (
        check_world,
        world(offset=lambda self, goals: torus.offset((goals + 1) % 9)),
        r"offset\(\) must be \(0, 0\) at the goal and nowhere else",
    ),
    "world: goal everywhere": (
        check_world,
        world(offset=lambda self, goals: [0 * way for way in torus.offset(goals)]),
        "nowhere else",
    ),
    "world: long way": (
        check_world,
        world(offset=lambda self, goals: [2 * way for way in torus.offset(goals)]),
        r"offset\(\) must lie within reach \(1, 1\), but goes as far as \(2, 2\)",
    ),
    "world: open cells as a list": (
        check_world,
        world(open_cells=lambda self: [0, 1]),
        r"open_cells\(\) should give int32 .* not list",
    ),
    "world: open cells outside": (
        check_world,
        opened(0, 9),
        r"open_cells\(\) should give .* from 0 to 8; it gives 0 to 9",
    ),
    "world: open cells twice": (
        check_world,
        opened(0, 1, 1),
        r"open_cells\(\) should give each cell once, in ascending order",
    ),
    "world: one open cell": (check_world, opened(4), "has only 1 open ones"),
    "world: no way": (
        check_world,
        world(next_cell=lambda self: np.where(next_cell == 4, np.arange(9, dtype=np.int32), next_cell)),
        r"must lead from every open cell to every other, but it does not: \(0, 4\)",
    ),
    "world: offset in floats": (
        check_world,
        world(offset=lambda self, goals: [way * 1.0 for way in torus.offset(goals)]),
        r"offset\(\) must be two arrays of whole numbers of shape \(2, 3, 1, 9\)",
    ),
    "codes: 32 bits": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals).astype(np.int32)),
        r"observation\(\) should give int64 .* not int32",
    ),
    "codes: no counter": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals)[..., 0, :]),
        r"observation\(\) should give int64 of shape \(2, 3, 1, 16\), not",
    ),
    "codes: negative": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals) - 1),
        "all from 0 to [0-9]+; it gives -1 to",
    ),
    "codes: more than the size": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals) + 1),
        r"must be less than spanned_size\(\) = 16",
    ),
    "codes: one layout only": (check_representation, representation(one_layout_only), "take many layouts at a time"),
    "codes: first layout for all": (
        check_representation,
        representation(first_layout_for_all),
        "must equal that of one at a time",
    ),
    "codes: count the calls": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals) + next(calls)),
        "must return the same values at every call",
    ),
    "codes: input changed": (check_representation, representation(shifts_its_input), "must not change the goals"),
    "codes: size in floats": (
        check_representation,
        misfit(AdHoc(), published_size=lambda self, world, n_goals: 1e3),
        r"published_size\(\) must be a positive whole number",
    ),
    "schedule: one short": (
        check_exploration,
        schedule(lambda trials: np.zeros(trials - 1)),
        r"schedule\(\) should give float64 of shape \(1,\), not float64 of shape \(0,\)",
    ),
    "schedule: 32 bits": (
        check_exploration,
        schedule(lambda trials: np.zeros(trials, np.float32)),
        "should give float64 .* not float32",
    ),
    "schedule: list": (check_exploration, schedule(lambda trials: [0.0] * trials), "should give float64 .* not list"),
    "schedule: above one": (
        check_exploration,
        schedule(lambda trials: np.arange(trials) / 50),
        "all from 0 to 1; it gives 0.0 to 1.98",
    ),
    "schedule: below zero": (
        check_exploration,
        schedule(lambda trials: np.full(trials, -0.1)),
        "all from 0 to 1; it gives -0.1",
    ),
    "schedule: no number": (
        check_exploration,
        schedule(lambda trials: np.full(trials, NAN)),
        "all from 0 to 1; it gives nan",
    ),
    "schedule: by chance": (
        check_exploration,
        schedule(lambda trials: np.full(trials, next(calls) / 1e6)),
        "must return the same values at every call",
    ),
    "reward: two": (check_reward, reward(np.zeros(2)), r"should give float64 of shape \(3,\), not"),
    "reward: whole numbers": (check_reward, reward(np.zeros(3, dtype=int)), "should give float64 .* not int64"),
    "reward: infinite": (check_reward, reward(np.array([0.0, 1.0, np.inf])), "it gives 0.0 to inf"),
    "lengths: 64 bits": (check_msa, lengths(1, 2, 3, dtype=np.int64), "should give int32 .* not int64"),
    "lengths: too few": (check_msa, lengths(1, 2), r"should give int32 of shape \(3,\), not"),
    "lengths: no primitive actions": (check_msa, lengths(2, 1, 3), "should begin with 1"),
    "lengths: no step": (check_msa, lengths(1, 0, 3), "all from 1 to 1000000; it gives 0 to 3"),
    "lengths: twice": (check_msa, lengths(1, 3, 3), "should begin with 1 and hold every length once"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_breach_is_reported(name: str):
    check, component, message = BROKEN[name]
    with pytest.raises(AssertionError, match=message):
        check(component)


def test_checks_survive_an_optimised_interpreter():
    program = (
        "from rl_design_space.contracts import check_reward\n"
        "from rl_design_space.design import Constant\n"
        "check_reward(Constant())"
    )
    command = [sys.executable, "-O", "-c", program]
    checked = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=PATIENCE)
    assert "Constant must have every member of Reward" in checked.stderr


def test_a_contract_is_importable_without_the_test_framework():
    program = "import sys, rl_design_space.contracts; print({'pytest', 'hypothesis', 'numba'} & set(sys.modules))"
    assert python(program, cwd=ROOT).strip() == "set()"
