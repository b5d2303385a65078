"""Reachability of cells in a world, from its transitions or from everything that may happen in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def reached_from(next_cell: NDArray[np.int32], start: int) -> NDArray[np.bool_]:
    """Return (cells,) whether each cell can be reached from a start; the start itself is reached.

    Args:
        next_cell: (ways, cells) cells that can come next, such as a transition table.
        start: number of a cell.
    """
    reached = np.zeros(next_cell.shape[1], dtype=np.bool_)
    new = np.array([start])
    while new.size:
        reached[new] = True
        new = np.unique(next_cell[:, new])
        new = new[~reached[new]]
    return reached


def leading_to(next_cell: NDArray[np.int32], goal: int) -> NDArray[np.bool_]:
    """Return (cells,) whether a goal can be reached from each cell; from the goal itself it can.

    Args:
        next_cell: (ways, cells) cells that can come next, such as a transition table.
        goal: number of a cell.
    """
    leading = np.zeros(next_cell.shape[1], dtype=np.bool_)
    leading[goal], count = True, 0
    while count < (count := int(leading.sum())):
        leading |= leading[next_cell].any(axis=0)
    return leading


def missing_way(next_cell: NDArray[np.int32], cells: NDArray[np.int32]) -> tuple[int, int] | None:
    """Return two cells with no path from the first to the second; None if every cell can be reached from every other.

    Args:
        next_cell: (ways, cells) cells that can come next, such as a transition table.
        cells: cell numbers.
    """
    first = int(cells[0])
    unreached = cells[~reached_from(next_cell, first)[cells]]
    if unreached.size:
        return first, int(unreached[0])
    caught = cells[~leading_to(next_cell, first)[cells]]
    return (int(caught[0]), first) if caught.size else None
