"""What an observation shows of the agent and the goals, and so what an action can depend on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import IntArray

if TYPE_CHECKING:
    from rl_design_space.design.world import World

#: In place of the sign of an offset, or of whether a step is blocked, that an observation does not show.
UNKNOWN = 2


class Sight(NamedTuple):
    """What observations show, by observation; an array of any shape (...) holds one number for each.

    A representation computes it from observation codes alone, see `SightedRepresentation`, so equal observations show
    the same.

    Attributes:
        world: where the agent moves.
        counter: (...) success counter, the number of the due goal.
        x: (n_goals, ...) int8, sign of the offset to each goal along x: 1 to the right, -1 to the left, 0 level with
            it, or `UNKNOWN`.
        y: (n_goals, ...) int8, the same along y: 1 below, -1 above.
        cell: (...) number of the agent's cell, or -1 where it is not shown.
    """

    world: World
    counter: IntArray
    x: NDArray[np.int8]
    y: NDArray[np.int8]
    cell: IntArray

    def due_goal(self) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
        """Return the signs of the offset to the due goal along x and y, (...) each."""
        return self._goal(self.counter)

    def last_goal(self) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
        """Return the signs of the offset to the goal reached last, `UNKNOWN` if there is none."""
        x, y = self._goal(np.maximum(self.counter - 1, 0))
        none = self.counter == 0
        return np.where(none, np.int8(UNKNOWN), x), np.where(none, np.int8(UNKNOWN), y)

    def of_cell(self, table: IntArray, otherwise: int) -> IntArray:
        """Return the value of a table by cell, (..., cells), at the agent's cell; another one where it is not shown."""
        return np.where(self.cell < 0, otherwise, table[..., np.maximum(self.cell, 0)])

    def _goal(self, number: IntArray) -> tuple[NDArray[np.int8], NDArray[np.int8]]:
        at = number[np.newaxis]
        return np.take_along_axis(self.x, at, axis=0)[0], np.take_along_axis(self.y, at, axis=0)[0]


def unseen(shape: tuple[int, ...]) -> NDArray[np.int8]:
    """Return signs that are not shown, (n_goals, ...)."""
    return np.full(shape, UNKNOWN, dtype=np.int8)
