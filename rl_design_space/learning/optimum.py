"""The exact optimum: the shortest tour from the start through all goals in their order; by chance, on average."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, Optimum
from rl_design_space.design import Outcomes, possible_cells
from rl_design_space.errors import ConfigError
from rl_design_space.learning.compiled import compiled, compiled_and_kept
from rl_design_space.learning.tables import Tables

#: Expected steps are final when no cell's change by more than this, relative to the largest.
_TOLERANCE = 1e-13


def optimal_steps(tables: Tables, layout: NDArray[np.int32]) -> Optimum:
    """Return the fewest steps that solve each layout, (periods,) int32; those expected, float64, in a stochastic world.

    Args:
        tables: of the design point.
        layout: (periods, 1 + n_goals) start and goals.

    Raises:
        ConfigError: a goal cannot be reached, or only by luck.
    """
    if tables.outcomes is None:
        return shortest_tours(tables.next_cell, layout)
    return expected_tours(tables.outcomes, layout)


def needed(optimum: float) -> str:
    """Return the optimum of a layout in words, such as `at least 12 needed`."""
    return f"at least {optimum} needed" if isinstance(optimum, int) else f"at least {optimum:.1f} expected"


def luckiest_tours(tables: Tables, layout: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the fewest steps that can solve each layout, whatever happens by chance."""
    if tables.outcomes is None:
        return shortest_tours(tables.next_cell, layout)
    return shortest_tours(possible_cells(tables.outcomes), layout)


def expected_tours(outcomes: Outcomes, layout: NDArray[np.int32]) -> FloatArray:
    """Return the fewest steps that can be expected in each layout: the sum of its legs, by value iteration.

    Args:
        outcomes: of the world.
        layout: (periods, 1 + n_goals) start and goals.

    Returns:
        (periods,) float64 steps.

    Raises:
        ConfigError: no policy is sure to reach a goal.
    """
    goals, which = np.unique(layout[:, 1:], return_inverse=True)
    steps = expected_steps(outcomes, goals)
    tours: FloatArray = steps[which.reshape(len(layout), -1), layout[:, :-1]].sum(axis=1)
    if np.isinf(tours).any():
        period = int(np.flatnonzero(np.isinf(tours))[0])
        cells = layout[period].tolist()
        raise ConfigError(f"world: in period {period} no policy is sure to pass the cells {cells} in this order")
    return tours


def expected_steps(outcomes: Outcomes, goals: NDArray[np.int32]) -> FloatArray:
    """Return the fewest expected steps from every cell to each goal, (goals, cells); infinity where none is sure to."""
    cells, probabilities = (np.ascontiguousarray(each.swapaxes(0, 1)) for each in outcomes)
    steps: FloatArray = _expected(cells, probabilities, goals.astype(np.int64))
    return steps


@compiled
def _is_sure(cells, probabilities, goal, sure):
    """Find the cells from which a policy reaches the goal with certainty.

    Of the cells that are left, those are left that can reach the goal by steps that never leave the cells that are
    left; until none is taken away.
    """
    count, moves, k = cells.shape
    sure[:] = True
    leading = np.empty(count, dtype=np.bool_)
    left = -1
    while left != sure.sum():
        left = sure.sum()
        leading[:] = False
        leading[goal] = True
        grows = True
        while grows:
            grows = False
            for cell in range(count):
                if leading[cell] or not sure[cell]:
                    continue
                for move in range(moves):
                    stays, leads = True, False
                    for at in range(k):
                        if probabilities[cell, move, at] > 0:
                            stays &= sure[cells[cell, move, at]]
                            leads |= leading[cells[cell, move, at]]
                    if stays and leads:
                        leading[cell] = grows = True
                        break
        for cell in range(count):
            sure[cell] = leading[cell]


@compiled_and_kept
def _expected(cells, probabilities, goals):
    """Return expected steps, (goals, cells), by value iteration in alternating order.

    Args:
        cells: (cells, 4, k).
        probabilities: (cells, 4, k).
        goals: cell numbers.
    """
    count, moves, k = cells.shape
    found = np.zeros((len(goals), count))
    sure = np.empty(count, dtype=np.bool_)
    for number in range(len(goals)):
        goal, steps = goals[number], found[number]
        _is_sure(cells, probabilities, goal, sure)
        for cell in range(count):
            steps[cell] = 0.0 if sure[cell] else np.inf
        change, largest, backwards = np.inf, 1.0, False
        while change > _TOLERANCE * largest:
            change = 0.0
            for place in range(count):
                cell = count - 1 - place if backwards else place
                if cell == goal or not sure[cell]:
                    continue
                best = np.inf
                for move in range(moves):
                    # A step that leads nowhere is tried again until it leads elsewhere.
                    again, further = 0.0, 1.0
                    for at in range(k):
                        there, p = cells[cell, move, at], probabilities[cell, move, at]
                        if there == cell:
                            again += p
                        elif p > 0:
                            further += p * steps[there]
                    if again < 1:
                        best = min(best, further / (1 - again))
                change = max(change, abs(best - steps[cell]))
                largest = max(largest, best)
                steps[cell] = best
            backwards = not backwards
    return found


def shortest_tours(next_cell: NDArray[np.int32], layout: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the fewest steps that solve each layout: the sum of its shortest legs.

    Args:
        next_cell: (ways, cells) cells that can come next: the transition table of any deterministic world, with four.
        layout: (periods, 1 + n_goals) start and goals.

    Returns:
        (periods,) int32 steps.

    Raises:
        ConfigError: a goal cannot be reached.
    """
    # A copy: the search would be compiled again for a read-only array.
    tours: NDArray[np.int32] = _tours(next_cell, np.array(layout), np.argsort(layout[:, :-1], axis=None))
    if (tours < 0).any():
        period = int(np.flatnonzero(tours < 0)[0])
        cells = layout[period].tolist()
        raise ConfigError(f"world: in period {period} no way leads through the cells {cells} in this order")
    return tours


@compiled_and_kept
def _tours(next_cell, layout, order):
    """Search breadth-first from every cell where legs begin, for all its legs at once; -1 where there is no path.

    Args:
        next_cell: see `shortest_tours`.
        layout: see `shortest_tours`.
        order: (legs of all periods,) numbers of legs, those from the same cell one after the other. Numba would compile
            the sorting in a second.
    """
    cells = next_cell.shape[1]
    legs = layout.shape[1] - 1
    sources, targets = layout[:, :-1].copy().ravel(), layout[:, 1:].copy().ravel()
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
            for move in range(len(next_cell)):
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
