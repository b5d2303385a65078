"""Contracts of the components: what every option keeps to, those of the package and your own.

Each check takes a built component and raises an AssertionError that names what is wrong:

    from rl_design_space.contracts import check_representation

    def test_my_representation():
        check_representation(MyRepresentation(radius=2))
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import (
    Exploration,
    MultiStepActions,
    ObstructedWorld,
    Reward,
    Torus,
    Walled,
    World,
    cell_count,
    open_cells,
)
from rl_design_space.design.representation import Representation, SizedRepresentation
from rl_design_space.learning.ways import missing_way

_WORLDS: tuple[World, ...] = (Torus(size=4), Torus(size=(5, 3)), Walled(size=(2, 4)))
_TRIALS = (1, 2, 7, 100)
#: Goals whose offsets are examined: all cells of a small world, a sample of a large one.
_MOST_GOALS = 64


def check_world(world: World) -> None:
    """Shape, transition table, open cells, offsets and reach of a world; a way from every open cell to every other."""
    _check_value(world, World)
    for name, pair in (("shape", world.shape), ("reach", world.reach)):
        whole = isinstance(pair, tuple) and [type(side) for side in pair] == [int, int]
        _expect(whole and min(pair) >= (name == "shape"), f"{name} must be two whole numbers, along x and y: {pair}")
    cells = cell_count(world)

    table = world.next_cell()
    _check_array("next_cell()", table, (4, cells), np.int32)
    _expect(bool(((table >= 0) & (table < cells)).all()), f"next_cell() must stay inside the world of {cells} cells")
    _expect(np.array_equal(table, world.next_cell()), "next_cell() must give the same at every call")

    free = open_cells(world)
    if isinstance(world, ObstructedWorld):
        _check_array("open_cells()", free, (np.size(free),), np.int32)
        _expect(bool(((free >= 0) & (free < cells)).all()), f"open_cells() must lie in the world of {cells} cells")
        _expect(len(free) > 1 and bool((np.diff(free) > 0).all()), "open_cells() must be several, in ascending order")
        _expect(np.array_equal(free, world.open_cells()), "open_cells() must give the same at every call")
    missing = missing_way(table, free)
    _expect(missing is None, f"next_cell() must lead from every open cell to every other, but it does not: {missing}")

    _check_layouts("offset() along x", lambda goals: world.offset(goals)[0], cells, np.integer)
    _check_layouts("offset() along y", lambda goals: world.offset(goals)[1], cells, np.integer)
    goals = np.unique(np.linspace(0, cells - 1, _MOST_GOALS).astype(np.int32))
    x, y = world.offset(goals)
    at_goal = goals[:, np.newaxis] == np.arange(cells)
    _expect(np.array_equal((x == 0) & (y == 0), at_goal), "offset() must be (0, 0) at the goal and nowhere else")
    farthest = int(np.abs(x).max()), int(np.abs(y).max())
    within = farthest[0] <= world.reach[0] and farthest[1] <= world.reach[1]
    _expect(within, f"offset() must lie within reach {world.reach}, not as far as {farthest}")


def check_representation(representation: Representation, worlds: Sequence[World] = _WORLDS) -> None:
    """Observation codes of a representation, for layouts of one to three goals in each of these worlds."""
    _check_value(representation, Representation)
    for world in worlds:
        for n_goals in range(1, 1 + min(3, cell_count(world) - 1)):
            table = partial(representation.observation, world)
            codes = _check_layouts("observation()", table, cell_count(world), np.int64, n_goals)
            _expect(int(codes.min()) >= 0, "observation() codes must not be negative")
            if isinstance(representation, SizedRepresentation):
                size = representation.spanned_size(world, n_goals)
                _expect(int(codes.max()) < size, f"observation() codes must be less than spanned_size() = {size}")
                published = representation.published_size(world, n_goals)
                _expect(type(published) is int and published > 0, "published_size() must be a positive whole number")


def check_exploration(exploration: Exploration) -> None:
    """Length, type and range of a schedule, for several numbers of trials."""
    _check_value(exploration, Exploration)
    for trials in _TRIALS:
        epsilon = exploration.schedule(trials)
        _check_array(f"schedule({trials})", epsilon, (trials,), np.float64)
        _expect(bool(((epsilon >= 0) & (epsilon <= 1)).all()), f"schedule({trials}) must be probabilities, 0 to 1")
        again = exploration.schedule(trials)
        _expect(np.array_equal(epsilon, again), f"schedule({trials}) must give the same at every call")


def check_reward(reward: Reward) -> None:
    """Three finite rewards."""
    _check_value(reward, Reward)
    table = reward.table()
    _check_array("table()", table, (3,), np.float64)
    _expect(bool(np.isfinite(table).all()), "table() must be finite rewards")
    _expect(np.array_equal(table, reward.table()), "table() must give the same at every call")


def check_msa(msa: MultiStepActions) -> None:
    """Lengths of a set of actions: the primitive moves first, then every other length once."""
    _check_value(msa, MultiStepActions)
    table = msa.action_lengths()
    _check_array("action_lengths()", table, (1 + len(msa.lengths),), np.int32)
    _expect(int(table[0]) == 1, "action_lengths() must begin with 1, the primitive moves")
    _expect(int(table.min()) >= 1, "action_lengths() must be lengths of at least one move")
    _expect(len(np.unique(table)) == len(table), "action_lengths() must not hold a length twice")
    _expect(np.array_equal(table, msa.action_lengths()), "action_lengths() must give the same at every call")


def check_study(name: str, config_dir: str | Path | None = None) -> None:
    """A study can be planned, every value of its points is allowed, and its report can be built if it has one.

    Args:
        name: of its file in `study/`.
        config_dir: folder of your own that holds it.
    """
    from rl_design_space.config.compose import shipped_config
    from rl_design_space.config.user_config import used
    from rl_design_space.errors import ConfigError
    from rl_design_space.plan.study import load_study

    try:
        with used(config_dir), shipped_config():
            study = load_study(name, ())
            if "report" in study.config.study:
                study.report()
    except ConfigError as error:
        raise AssertionError(str(error)) from error


def _expect(kept: bool, otherwise: str) -> None:
    """Raise what a contract says; unlike `assert`, also under `python -O`."""
    if not kept:
        raise AssertionError(otherwise)


def _check_value(component: object, protocol: type) -> None:
    """A component is built, does what its choice asks for, and is a value: frozen, hashable, equal to its copy."""
    name = type(component).__name__
    _expect(not isinstance(component, type), f"{component} must be built: give an instance, not its class")
    _expect(isinstance(component, protocol), f"{name} must have every member of {protocol.__name__}")
    frozen = getattr(getattr(component, "__dataclass_params__", None), "frozen", False)
    _expect(frozen, f"{name} must be a frozen dataclass")
    try:
        hash(component)
    except TypeError as error:
        raise AssertionError(f"{name} must be hashable: {error}") from error
    twin = copy.deepcopy(component)
    _expect(twin == component and hash(twin) == hash(component), f"{name} must equal a copy of itself, with its hash")


def _check_array(name: str, array: object, shape: tuple[int, ...], dtype: Any) -> None:
    """A NumPy array of this shape, and of this type of numbers or one that belongs to it."""
    _expect(isinstance(array, np.ndarray), f"{name} must be a NumPy array, not {type(array).__name__}")
    found: NDArray[Any] = np.asarray(array)
    _expect(found.shape == shape, f"{name} must have the shape {shape}, not {found.shape}")
    _expect(np.issubdtype(found.dtype, dtype), f"{name} must have the dtype {dtype.__name__}, not {found.dtype}")


def _check_layouts(
    name: str, table: Callable[[NDArray[Any]], Any], cells: int, dtype: Any, n_goals: int = 1
) -> NDArray[Any]:
    """A table of layouts is the same for many as for one at a time, at every call, and leaves the goals alone."""
    goals = np.arange(6 * n_goals, dtype=np.int32).reshape(2, 3, n_goals) % cells
    given = goals.copy()
    try:
        many = table(given)
    except Exception as error:
        raise AssertionError(f"{name} must take many layouts at a time, (..., n_goals): {error}") from error
    _expect(np.array_equal(given, goals), f"{name} must not change the goals that it is given")
    _check_array(name, many, (2, 3, n_goals, cells), dtype)
    expected: NDArray[Any] = many.copy()
    for index in np.ndindex(2, 3):
        one = table(goals[index])
        _check_array(name, one, (n_goals, cells), dtype)
        _expect(np.array_equal(one, expected[index]), f"{name} of many layouts must equal that of one at a time")
    _expect(np.array_equal(table(goals), expected), f"{name} must give the same at every call")
    return expected
