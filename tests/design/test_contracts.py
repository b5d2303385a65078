"""Every built-in option keeps its contract, and every breach of a contract is found and named."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path

import numpy as np
import pytest

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
    Direct,
    Direction,
    Distance,
    Exponential,
    GoalReward,
    Linear,
    MultiStepActions,
    Sigmoidal,
    Torus,
    Walled,
)
from tests.command_runner import PATIENCE, python
from tests.misfits import misfit

ROOT = Path(__file__).parents[2]

KEPT = [
    (check_world, Torus()),
    (check_world, Torus(size=2)),
    (check_world, Torus(size=(100, 3))),
    (check_world, Walled()),
    (check_world, Walled(size=(2, 9))),
    (check_world, misfit(Walled(size=3), open_cells=lambda self: np.array([0, 1, 3], dtype=np.int32))),
    (check_representation, AdHoc()),
    (check_representation, Distance()),
    (check_representation, Distance(goals="remaining")),
    (check_representation, Direction()),
    (check_representation, Direction(goals="remaining")),
    (check_representation, Direction(rule="horizontal_first")),
    (check_representation, Direction(rule="horizontal_first", goals="remaining")),
    (check_representation, Direct()),
    (check_exploration, Constant()),
    (check_exploration, Linear()),
    (check_exploration, Exponential()),
    (check_exploration, Exponential(start=0.01, l=0.5)),
    (check_exploration, Sigmoidal()),
    (check_reward, GoalReward()),
    (check_msa, MultiStepActions()),
    (check_msa, MultiStepActions(lengths=(5, 2, 3))),
]


@pytest.mark.parametrize(("check", "component"), KEPT, ids=lambda value: getattr(value, "__name__", None) or str(value))
def test_built_in_options_keep_their_contract(check, component):
    check(component)


def test_a_representation_can_be_checked_in_worlds_of_ones_own():
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
    "world: list of moves": (check_world, world(next_cell=next_cell.tolist), r"next_cell\(\) must be a NumPy array"),
    "world: transposed": (check_world, world(next_cell=lambda self: next_cell.T), r"have the shape \(4, 9\)"),
    "world: 64 bits": (check_world, world(next_cell=lambda self: next_cell.astype(int)), "have the dtype int32"),
    "world: a way out": (check_world, world(next_cell=lambda self: next_cell + np.int32(1)), "stay inside the world"),
    "world: below zero": (check_world, world(next_cell=lambda self: next_cell - np.int32(1)), "stay inside the world"),
    "world: moving walls": (
        check_world,
        world(next_cell=lambda self: np.roll(next_cell, next(calls), axis=0)),
        r"next_cell\(\) must give the same at every call",
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
        r"offset\(\) must lie within reach \(1, 1\), not as far as \(2, 2\)",
    ),
    "world: open cells as a list": (check_world, world(open_cells=lambda self: [0, 1]), "must be a NumPy array"),
    "world: open cells outside": (check_world, opened(0, 9), r"open_cells\(\) must lie in the world of 9 cells"),
    "world: open cells twice": (check_world, opened(0, 1, 1), "must be several, in ascending order"),
    "world: one open cell": (check_world, opened(4), "must be several"),
    "world: no way": (
        check_world,
        world(next_cell=lambda self: np.where(next_cell == 4, np.arange(9, dtype=np.int32), next_cell)),
        r"must lead from every open cell to every other, but it does not: \(0, 4\)",
    ),
    "world: offset in floats": (
        check_world,
        world(offset=lambda self, goals: [way * 1.0 for way in torus.offset(goals)]),
        r"offset\(\) along x must have the dtype integer",
    ),
    "codes: 32 bits": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals).astype(np.int32)),
        r"observation\(\) must have the dtype int64, not int32",
    ),
    "codes: no counter": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals)[..., 0, :]),
        r"observation\(\) must have the shape",
    ),
    "codes: negative": (
        check_representation,
        representation(lambda self, world, goals: ad_hoc(world, goals) - 1),
        "must not be negative",
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
        "must equal that of one at a time",
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
        r"schedule\(1\) must have",
    ),
    "schedule: 32 bits": (check_exploration, schedule(lambda trials: np.zeros(trials, np.float32)), "dtype float64"),
    "schedule: list": (check_exploration, schedule(lambda trials: [0.0] * trials), "NumPy array, not list"),
    "schedule: above one": (
        check_exploration,
        schedule(lambda trials: np.arange(trials) / 50),
        r"schedule\(100\) must",
    ),
    "schedule: below zero": (check_exploration, schedule(lambda trials: np.full(trials, -0.1)), "probabilities"),
    "schedule: no number": (check_exploration, schedule(lambda trials: np.full(trials, NAN)), "probabilities"),
    "schedule: by chance": (
        check_exploration,
        schedule(lambda trials: np.full(trials, next(calls) / 1e6)),
        "must give the same at every call",
    ),
    "reward: two": (check_reward, reward(np.zeros(2)), r"have the shape \(3,\)"),
    "reward: whole numbers": (check_reward, reward(np.zeros(3, dtype=int)), "have the dtype float64"),
    "reward: infinite": (check_reward, reward(np.array([0.0, 1.0, np.inf])), "finite"),
    "lengths: 64 bits": (check_msa, lengths(1, 2, 3, dtype=np.int64), "have the dtype int32"),
    "lengths: too few": (check_msa, lengths(1, 2), r"have the shape \(3,\)"),
    "lengths: no primitive moves": (check_msa, lengths(2, 1, 3), "must begin with 1"),
    "lengths: no move": (check_msa, lengths(1, 0, 3), "at least one move"),
    "lengths: twice": (check_msa, lengths(1, 3, 3), "must not hold a length twice"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_breach_is_named(name: str):
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
