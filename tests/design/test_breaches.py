"""Every breach of a contract is reported."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from itertools import count

import numpy as np
import pytest

from rl_design_space.contracts import check_exploration, check_msa, check_representation, check_reward, check_world
from rl_design_space.design import (
    WAIT,
    AdHoc,
    Constant,
    Controllers,
    Distance,
    GoalReward,
    MultiStepActions,
    SeeingActions,
    Torus,
)
from tests.misfits import misfit

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


class Peeping(SeeingActions):
    """Actions that go where the next goal is, although the observation does not show it."""

    names = ("peeping", "waiting")

    def behaviour(self, world, representation, goals, codes):
        x, _ = world.offset(goals)
        found = super().behaviour(world, representation, goals, codes)
        found.steps[4] = np.where(x > 0, 0, 1)
        return found

    def moves(self, sight):
        return np.full((2, *sight.counter.shape), WAIT, dtype=np.int8)


def acts(**members: object) -> object:
    moving = {"moves": lambda self, sight: np.zeros((2, *sight.counter.shape), dtype=np.int8)}
    return misfit(Peeping(), behaviour=SeeingActions.behaviour, **(moving | members))


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
        "all at least 0; it gives -1 to",
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
    "actions: more than is seen": (check_msa, Peeping(), "must be the same at equal observations"),
    "actions: a step that does not exist": (
        check_msa,
        acts(moves=lambda self, sight: np.full((2, *sight.counter.shape), 5, dtype=np.int8)),
        "all from 0 to 4; it gives 0 to 5",
    ),
    "actions: one for two names": (
        check_msa,
        acts(moves=lambda self, sight: np.zeros((1, *sight.counter.shape), dtype=np.int8)),
        r"msa: .*moves\(\) should give int8 of shape \(2, 2, 3, 1, 16\), not int8 of shape \(1, 2, 3, 1, 16\)",
    ),
    "actions: steps by chance": (
        check_msa,
        acts(moves=lambda self, sight: np.full((2, *sight.counter.shape), next(calls) % 4, dtype=np.int8)),
        "must return the same values at every call|must equal that of one at a time",
    ),
    "actions: a limit too few": (
        check_msa,
        acts(limits=lambda self: np.ones(5, dtype=np.int32)),
        r"limits\(\) should give int32 of shape \(6,\), not int32 of shape \(5,\)",
    ),
    "actions: nothing shown": (
        partial(check_msa, representations=[Distance()]),
        Controllers(),
        "must fit a representation: no one shows what its actions need",
    ),
    "lengths: twice": (check_msa, lengths(1, 3, 3), "should begin with 1 and hold every length once"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_breach_is_reported(name: str):
    check, component, message = BROKEN[name]
    with pytest.raises(AssertionError, match=message):
        check(component)
