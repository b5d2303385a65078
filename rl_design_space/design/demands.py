"""What contracts demand of every component: a value, equal tables at every call, many layouts at a time."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import IntArray
from rl_design_space.errors import ConfigError


def expect(kept: bool, otherwise: str) -> None:
    """Raise an AssertionError unless a contract is kept; unlike `assert`, also under `python -O`."""
    if not kept:
        raise AssertionError(otherwise)


def check_value(component: object, protocol: type) -> None:
    """Check that a component is an instance, fulfils its protocol and is a value: frozen, hashable, equal to a copy."""
    name = type(component).__name__
    expect(not isinstance(component, type), f"{component} must be built: give an instance, not its class")
    expect(isinstance(component, protocol), f"{name} must have every member of {protocol.__name__}")
    frozen = getattr(getattr(component, "__dataclass_params__", None), "frozen", False)
    expect(frozen, f"{name} must be a frozen dataclass")
    try:
        hash(component)
    except TypeError as error:
        raise AssertionError(f"{name} must be hashable: {error}") from error
    twin = copy.deepcopy(component)
    expect(twin == component and hash(twin) == hash(component), f"{name} must equal a copy of itself, with its hash")


def repeatable(name: str, table: Callable[[], Any]) -> Any:
    """Return a table that learning accepts, and that is equal at every call."""
    try:
        found, again = table(), table()
    except ConfigError as error:
        raise AssertionError(str(error)) from error
    expect(np.array_equal(found, again), f"{name} must return the same values at every call")
    return found


def check_layouts(name: str, table: Callable[[IntArray], NDArray[Any]], cells: int, n_goals: int = 1) -> NDArray[Any]:
    """Return a table of many layouts that equals those of one at a time, at every call, and leaves the goals alone."""
    goals = layouts(cells, n_goals)
    given = goals.copy()
    try:
        many = table(given).copy()
    except ConfigError as error:
        raise AssertionError(str(error)) from error
    except AssertionError:
        raise
    except Exception as error:
        raise AssertionError(f"{name} must take many layouts at a time, (..., n_goals): {error}") from error
    expect(np.array_equal(given, goals), f"{name} must not change the goals that it is given")
    for index in np.ndindex(2, 3):
        one = repeatable(name, partial(table, goals[index]))
        expect(np.array_equal(one, many[index]), f"{name} of many layouts must equal that of one at a time")
    expect(np.array_equal(table(goals), many), f"{name} must return the same values at every call")
    return many


def layouts(cells: int, n_goals: int) -> IntArray:
    """Return the goals of six layouts, (2, 3, n_goals)."""
    return np.arange(6 * n_goals, dtype=np.int32).reshape(2, 3, n_goals) % cells
