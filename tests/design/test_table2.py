"""Table 2 of the paper: the number of states of a representation, and the number of codes that occur."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest

from rl_design_space.design import (
    AdHoc,
    Direct,
    Direction,
    Distance,
    SizedRepresentation,
    Torus,
    Walled,
    World,
    cell_count,
)

TABLE_2 = [
    (AdHoc(), 10, (100, 200, 300, 400, 500)),
    (AdHoc(), 20, (400, 800, 1200, 1600, 2000)),
    (Distance(), 10, (10, 200, 3000, 40_000, 500_000)),
    (Distance(), 20, (20, 800, 24_000, 640_000, 16_000_000)),
    (Direction(), 10, (5, 50, 375, 2500, 15_625)),
    (Direction(), 20, (5, 50, 375, 2500, 15_625)),
    # The caption gives the formula only.
    (Direct(), 10, (100, 20_000, 3 * 100**3, 4 * 100**4, 5 * 100**5)),
    (Direct(), 20, (400, 320_000, 3 * 400**3, 4 * 400**4, 5 * 400**5)),
]
CELLS = [
    pytest.param(representation, size, n_goals, states, id=f"{type(representation).__name__}-{size}-{n_goals}")
    for representation, size, row in TABLE_2
    for n_goals, states in enumerate(row, start=1)
]

#: As the formulas count: with the goals that are reached already.
REPRESENTATIONS = [
    AdHoc(),
    Distance(goals="all"),
    Direction(goals="all"),
    Direction(rule="horizontal_first", goals="all"),
    Direct(),
]
TINY_WORLDS = [Torus(size=3), Torus(size=(4, 3)), Walled(size=3), Walled(size=(3, 4))]


def codes_of(representation: SizedRepresentation, world: World, layouts: list[tuple[int, ...]]) -> np.ndarray:
    """Return every code that occurs in these layouts, once."""
    return np.unique(representation.observation(world, np.array(layouts)))


@pytest.mark.parametrize(("representation", "size", "n_goals", "states"), CELLS)
def test_published_size(representation: SizedRepresentation, size: int, n_goals: int, states: int):
    assert representation.published_size(Torus(size=size), n_goals) == states


def test_rectangles_have_a_published_size_too():
    world = Torus(size=(10, 5))
    assert [option.published_size(world, 2) for option in REPRESENTATIONS] == [100, 7**2 * 2, 50, 50, 50**2 * 2]


@pytest.mark.parametrize(
    ("representation", "size"),
    [
        (AdHoc(), 300),
        (Distance(), 11**3 * 3),
        (Direction(), 375),
        (Direct(), 100**4 * 3),
    ],
    ids=str,
)
def test_spanned_size_of_the_default_task(representation: SizedRepresentation, size: int):
    assert representation.spanned_size(Torus(), 3) == size


@pytest.mark.parametrize("n_goals", [1, 2])
@pytest.mark.parametrize("world", TINY_WORLDS, ids=str)
@pytest.mark.parametrize("representation", REPRESENTATIONS, ids=str)
def test_no_layout_exceeds_the_spanned_size(representation: SizedRepresentation, world: World, n_goals: int):
    layouts = list(permutations(range(cell_count(world)), n_goals))
    codes = codes_of(representation, world, layouts)
    assert codes.min() >= 0
    assert codes.max() < representation.spanned_size(world, n_goals)


@pytest.mark.parametrize("n_goals", [1, 2])
@pytest.mark.parametrize("world", TINY_WORLDS, ids=str)
@pytest.mark.parametrize("representation", REPRESENTATIONS, ids=str)
def test_every_code_of_the_spanned_size_is_reached(representation: SizedRepresentation, world: World, n_goals: int):
    # The size takes no notice of goals being distinct, so neither do these layouts.
    layouts = list(product(range(cell_count(world)), repeat=n_goals))
    assert codes_of(representation, world, layouts).tolist() == list(range(representation.spanned_size(world, n_goals)))


@pytest.mark.parametrize("representation", [Distance(), Direction()], ids=str)
def test_masking_reached_goals_only_removes_codes(representation: SizedRepresentation):
    world = Torus(size=3)
    codes = codes_of(representation, world, list(product(range(9), repeat=2)))
    assert codes.min() >= 0
    assert codes.max() < representation.spanned_size(world, 2)
    assert len(codes) < representation.spanned_size(world, 2)
