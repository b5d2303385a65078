"""The best deterministic memoryless policy: against all policies there are, and where it is known by reasoning."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import (
    AdHoc,
    Controllers,
    DesignPoint,
    Direction,
    Distance,
    MultiStepActions,
    Representation,
    Task,
    Torus,
    Walled,
)
from rl_design_space.learning import memoryless
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.memoryless import best_memoryless, memoryless_steps
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.tables import learning_tables

ROW = Walled(size=(5, 2))  # no more than this: every policy is tried


def steps_of(tables, layout: np.ndarray, row: np.ndarray, policy: tuple[int, ...]) -> int | None:
    """Follow a policy; return its steps, or None if it never arrives or meets the step cap."""
    cell, counter, made, goals = int(layout[0]), 0, 0, layout[1:]
    for _ in range(row.size + 1):
        action = policy[row[counter, cell]]
        for _ in range(tables.limits[action]):
            cell = int(tables.next_cell[action % 4, cell])
            made += 1
            if reached := cell == goals[counter]:
                counter += 1
            if counter == len(goals):
                return made if made <= tables.rules.max_steps else None
            if reached and tables.rules.stop_at_sub_goal:
                break
    return None


@settings(deadline=None, max_examples=20)
@given(
    codes=st.lists(st.integers(0, 2), min_size=20, max_size=20),
    layout=st.permutations(range(10)).map(lambda cells: np.array(cells[:3], dtype=np.int32)),
    msa=st.sampled_from([(), (2,), (3,)]),
    stop=st.sampled_from(["stop", "continue"]),
    cap=st.sampled_from([8, 1000]),
    world=st.sampled_from([ROW, Torus(size=(5, 2))]),
)
def test_no_policy_is_better(codes, layout, msa, stop, cap, world):
    point = DesignPoint(
        world=world, task=Task(goals=2, max_steps=cap), msa=MultiStepActions(lengths=msa, sub_goal=stop)
    )
    tables = learning_tables(point)
    row = np.unique(codes, return_inverse=True)[1].reshape(2, 10)
    policies = product(range(len(tables.limits)), repeat=int(row.max()) + 1)
    known = [steps for policy in policies if (steps := steps_of(tables, layout, row, policy)) is not None]
    found = best_memoryless(point, tables, layout, row)
    assert found.is_exact
    assert found.steps == min(known, default=None)
    assert found.is_possible == bool(known)
    rough = best_memoryless(point, tables, layout, row, nodes=1)
    assert rough.bound <= found.bound
    assert rough.steps is None or rough.steps >= (found.steps or 0)


@pytest.mark.parametrize("representation", [AdHoc(), Distance(), Direction(), Direction(rule="horizontal_first")])
@pytest.mark.parametrize("world", [Torus(size=7), Walled(size=(6, 5))])
def test_the_optimum_can_be_represented_by_all_options(representation: Representation, world):
    point = DesignPoint(world=world, representation=representation, task=Task(goals=3, periods=20))
    layouts = layouts_of(point)
    np.testing.assert_array_equal(memoryless_steps(point, layouts), shortest_tours(world.next_cell(), layouts))


def test_an_agent_that_sees_nothing_may_have_no_policy():
    point = DesignPoint(world=Walled(size=4), task=Task(goals=1))
    blind, tables = np.zeros((1, 16), dtype=np.int64), learning_tables(point)
    aligned, diagonal = np.array([0, 3], dtype=np.int32), np.array([0, 5], dtype=np.int32)
    assert best_memoryless(point, tables, aligned, blind).steps == 3
    never = best_memoryless(point, tables, diagonal, blind)
    assert (never.steps, never.is_possible, never.is_exact) == (None, False, True)


def test_a_search_that_is_given_up_leaves_a_bound():
    point = DesignPoint(world=Torus(size=7), representation=Direction(), task=Task(goals=2))
    point = replace(point, msa=MultiStepActions(lengths=(3,)))
    (layout,) = layouts_of(replace(point, task=replace(point.task, periods=1)))
    codes = point.representation.observation(point.world, layout[1:])
    given_up = best_memoryless(point, learning_tables(point), layout, codes, nodes=0)
    assert (given_up.steps, given_up.is_exact, given_up.is_possible) == (None, False, True)
    assert given_up.bound == shortest_tours(point.world.next_cell(), layout[np.newaxis])[0]


@pytest.mark.parametrize("until", ["observation_changes", "due_goal_observation_changes"])
def test_actions_that_see_lead_to_the_optimum_on_directions(until: str):
    point = DesignPoint(world=Torus(size=5), representation=Direction(), task=Task(goals=2, periods=5))
    layouts = layouts_of(point)
    optimum = shortest_tours(point.world.next_cell(), layouts)
    stopping = replace(point, msa=MultiStepActions(lengths=(4,), until=until))
    np.testing.assert_array_equal(memoryless_steps(stopping, layouts), optimum)
    # Directions show one axis at a time, and each controller leads along one.
    alone = replace(point, msa=Controllers(primitives=False, sub_goal="stop"))
    np.testing.assert_array_equal(memoryless_steps(alone, layouts), optimum)


def test_policies_of_fewer_actions_spare_the_search(monkeypatch: pytest.MonkeyPatch):
    point = DesignPoint(world=Torus(size=6), representation=Direction(), task=Task(goals=2, periods=30))
    longer, layouts = replace(point, msa=MultiStepActions(lengths=(2, 3))), layouts_of(point)
    primitive, searched = memoryless_steps(point, layouts), memoryless_steps(longer, layouts)
    primitive[::10] += 1  # as if the optimum needed other actions there
    found, original = [], memoryless.best_memoryless
    monkeypatch.setattr(memoryless, "best_memoryless", lambda *given: found.append(given) or original(*given))
    np.testing.assert_array_equal(memoryless_steps(longer, layouts, primitive), searched)
    assert len(found) == 3
