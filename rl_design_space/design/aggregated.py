"""State aggregation: cells in blocks, whose values are one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.observing import Attribute
from rl_design_space.design.representation import SIDES, place_attributes
from rl_design_space.design.sight import Sight, unseen
from rl_design_space.design.world import World, cell_count
from rl_design_space.errors import ConfigError

_Side = Annotated[int, Field(ge=1)]


def _block(block: Any) -> Any:
    """Convert YAML's [2, 5] to a pair."""
    return tuple(block) if isinstance(block, list) else block


#: Cells along a side of a block, or along x and along y.
BlockSize = Annotated[
    _Side | tuple[_Side, _Side], BeforeValidator(_block, json_schema_input_type=_Side | tuple[_Side, _Side])
]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Aggregated:
    """The block of the agent's cell and the success counter; goals are implicit, as in `AdHoc`. Size dx·dy·n / (bx·by).

    The agent cannot tell the cells of a block apart, one with a goal included: it takes the same greedy action in all
    of them, and a goal is reached by stepping onto its own cell. Blocks of one cell are `AdHoc`.

    Attributes:
        block: size of a block, b, or [bx, by] along x and along y; it divides the size of the world.
    """

    block: BlockSize = 2

    @property
    def sides(self) -> tuple[int, int]:
        """Cells of a block along x and along y."""
        return (self.block, self.block) if isinstance(self.block, int) else self.block

    def check(self, world: World, n_goals: int) -> None:
        if all(size % side == 0 for size, side in zip(world.shape, self.sides, strict=True)):
            return
        (width, height), fitting = world.shape, [_divisors(size) for size in world.shape]
        sides = fitting[0] if width == height else f"{fitting[0]} along x and {fitting[1]} along y"
        raise ConfigError.at(
            "representation.block", self.block, f"does not divide the {width}×{height} world; sides that do are {sides}"
        )

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        x, y = self._places(world)
        return _by_counter(goals, y * (world.shape[0] // self.sides[0]) + x, self._blocks(world))

    def portable(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        x, y = self._places(world)
        return _by_counter(goals, y * SIDES + x, SIDES * SIDES)

    def attributes(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        return place_attributes(*self._places(world), goals.shape[-1])

    def sight(self, world: World, n_goals: int, codes: NDArray[np.int64]) -> Sight:
        counter, block = np.divmod(codes, self._blocks(world))
        nothing = unseen((n_goals, *codes.shape))
        return Sight(world, counter, nothing, nothing, block if self.sides == (1, 1) else np.full_like(codes, -1))

    def published_size(self, world: World, n_goals: int) -> int:
        return self._blocks(world) * n_goals

    def spanned_size(self, world: World, n_goals: int) -> int:
        return self._blocks(world) * n_goals

    def _places(self, world: World) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return the column and the row of the block of each cell, (cells,) each."""
        y, x = np.divmod(np.arange(cell_count(world), dtype=np.int64), world.shape[0])
        return x // self.sides[0], y // self.sides[1]

    def _blocks(self, world: World) -> int:
        (width, height), (across, down) = world.shape, self.sides
        return (width // across) * (height // down)


def _by_counter(goals: IntArray, block: NDArray[np.int64], blocks: int) -> NDArray[np.int64]:
    """Return the codes of layouts, (..., n_goals, cells), from the number of each cell's block, less than `blocks`."""
    n_goals = goals.shape[-1]
    codes = np.arange(n_goals, dtype=np.int64)[:, np.newaxis] * blocks + block
    return np.broadcast_to(codes, (*goals.shape[:-1], n_goals, len(block)))


def _divisors(size: int) -> str:
    return ", ".join(str(side) for side in range(1, size + 1) if size % side == 0)
