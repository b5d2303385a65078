"""The exact optimum: the shortest tour from the start through all goals in their order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space.errors import ConfigError
from rl_design_space.learning.compiled import compiled_and_kept


def shortest_tours(next_cell: NDArray[np.int32], layout: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the fewest steps that solve each layout: the sum of its shortest legs.

    Args:
        next_cell: (4, cells) transition table of any deterministic world.
        layout: (periods, 1 + n_goals) start and goals.

    Returns:
        (periods,) int32 steps.

    Raises:
        ConfigError: a goal cannot be reached.
    """
    tours: NDArray[np.int32] = _tours(next_cell, layout)
    if (tours < 0).any():
        period = int(np.flatnonzero(tours < 0)[0])
        cells = layout[period].tolist()
        raise ConfigError(f"world: in period {period} no way leads through the cells {cells} in this order")
    return tours


@compiled_and_kept
def _tours(next_cell, layout):
    """Search breadth-first from every cell where legs begin, for all its legs at once; -1 where there is no path."""
    cells = next_cell.shape[1]
    legs = layout.shape[1] - 1
    sources, targets = layout[:, :-1].copy().ravel(), layout[:, 1:].copy().ravel()
    order = np.argsort(sources)
    distance = np.empty(cells, dtype=np.int32)
    queue = np.empty(cells, dtype=np.int32)
    tours = np.zeros(len(layout), dtype=np.int32)
    searched = -1
    head = tail = 0
    for leg in order:
        if sources[leg] != searched:
            searched = sources[leg]
            distance[:] = -1
            distance[searched] = 0
            queue[0] = searched
            head, tail = 0, 1
        # Continue the search of the previous leg from the same cell.
        while head < tail and distance[targets[leg]] < 0:
            cell = queue[head]
            head += 1
            for move in range(4):
                neighbour = next_cell[move, cell]
                if distance[neighbour] < 0:
                    distance[neighbour] = distance[cell] + 1
                    queue[tail] = neighbour
                    tail += 1
        tour = leg // legs
        if distance[targets[leg]] < 0:
            tours[tour] = -1
        elif tours[tour] >= 0:
            tours[tour] += distance[targets[leg]]
    return tours
