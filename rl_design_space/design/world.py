"""Worlds: grids on which one step leads to the cell on the right, on the left, above or below (paper, section 2)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT

#: Primitive actions as (x, y), in the order of every table: right, left, above, below.
#: As in a picture, x grows to the right and y grows downwards.
MOVES = ((1, 0), (-1, 0), (0, -1), (0, 1))


@runtime_checkable
class World(Protocol):
    """A finite set of cells, numbered row by row, and the effect of the four primitive actions in each of them."""

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along x and along y."""
        ...

    def next_cell(self) -> NDArray[np.int32]:
        """Return the transition table, (4, cells) int32: the cell that each of `MOVES` leads to."""
        ...

    def offset(self, goals: IntArray) -> tuple[IntArray, IntArray]:
        """Return the signed offset from every cell to each goal, in cells along x and y.

        Args:
            goals: (..., n_goals) cell numbers.

        Returns:
            Two arrays (..., n_goals, cells): positive x is to the right, positive y is below.
        """
        ...

    @property
    def reach(self) -> tuple[int, int]:
        """Largest absolute offset along x and along y."""
        ...


@runtime_checkable
class ObstructedWorld(World, Protocol):
    """A world with cells where no start or goal can lie: obstacles, or cells that cannot be reached."""

    def open_cells(self) -> NDArray[np.int32]:
        """Return the cells where starts and goals may lie, (k,) int32, ascending, each reachable from every other."""
        ...


def cell_count(world: World) -> int:
    """Return the number of cells of a world."""
    width, height = world.shape
    return width * height


def open_cells(world: World) -> NDArray[np.int32]:
    """Return the cells where starts and goals may lie, (k,) int32: all cells, unless the world is obstructed."""
    return world.open_cells() if isinstance(world, ObstructedWorld) else np.arange(cell_count(world), dtype=np.int32)


def _canonical_size(size: Any) -> int | tuple[int, int]:
    """Convert the sides of a square to one number, so that `[10, 10]` and `10` are the same value."""
    sides = tuple(size) if isinstance(size, (list, tuple)) else (size, size)
    if len(sides) != 2 or not all(type(side) is int and side >= 2 for side in sides):
        raise ValueError("a size is a whole number of at least 2, or two of them, [dx, dy]")
    return sides[0] if sides[0] == sides[1] else sides


_Side = Annotated[int, Field(ge=2)]
#: Size of a grid: d for d×d cells, or (dx, dy).
GridSize = Annotated[
    int | tuple[int, int],
    BeforeValidator(_canonical_size, json_schema_input_type=_Side | tuple[_Side, _Side]),
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _Grid(ABC):
    """A rectangle of cells; subclasses define the border.

    Attributes:
        size: d for d×d cells, or [dx, dy].
    """

    size: GridSize = 10

    @property
    def shape(self) -> tuple[int, int]:
        return (self.size, self.size) if isinstance(self.size, int) else self.size

    def next_cell(self) -> NDArray[np.int32]:
        width, height = self.shape
        y, x = np.divmod(np.arange(width * height), width)
        moved = [self._inside(x + step_x, y + step_y) for step_x, step_y in MOVES]
        return np.array([new_y * width + new_x for new_x, new_y in moved], dtype=np.int32)

    def offset(self, goals: IntArray) -> tuple[IntArray, IntArray]:
        width, height = self.shape
        goal_y, goal_x = np.divmod(np.asarray(goals)[..., np.newaxis], width)
        # Offsets are computed once per row or column of cells, and then broadcast over the grid.
        offset_x = self._signed(goal_x - np.arange(width), width)[..., np.newaxis, :]
        offset_y = self._signed(goal_y - np.arange(height), height)[..., :, np.newaxis]
        grid = np.broadcast_shapes(offset_x.shape, offset_y.shape)
        flat = (*grid[:-2], width * height)
        return np.broadcast_to(offset_x, grid).reshape(flat), np.broadcast_to(offset_y, grid).reshape(flat)

    @abstractmethod
    def _inside(self, x: IntArray, y: IntArray) -> tuple[IntArray, IntArray]:
        """Return the cell that a step to (x, y) leads to, where (x, y) may lie beyond the border."""

    @abstractmethod
    def _signed(self, difference: IntArray, side: int) -> IntArray:
        """Convert a difference of coordinates along one axis to a signed offset."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Torus(_Grid):
    """_Grid with periodic boundary: a step over one border leads to the opposite side (paper, section 3).

    On an axis of even length a goal exactly half-way round is equally far in both directions; its offset is then
    positive (right, below).
    """

    @property
    def reach(self) -> tuple[int, int]:
        width, height = self.shape
        return width // 2, height // 2

    def _inside(self, x: IntArray, y: IntArray) -> tuple[IntArray, IntArray]:
        width, height = self.shape
        return x % width, y % height

    def _signed(self, difference: IntArray, side: int) -> IntArray:
        most_negative = (side - 1) // 2
        return (difference + most_negative) % side - most_negative


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Walled(_Grid):
    """_Grid with walls around it: a step against a wall leaves the agent where it is."""

    @property
    def reach(self) -> tuple[int, int]:
        width, height = self.shape
        return width - 1, height - 1

    def _inside(self, x: IntArray, y: IntArray) -> tuple[IntArray, IntArray]:
        width, height = self.shape
        return np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)

    def _signed(self, difference: IntArray, side: int) -> IntArray:
        return difference
