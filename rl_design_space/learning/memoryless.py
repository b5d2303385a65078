"""The best deterministic memoryless policy: how few steps it needs if the same observation always gets the same action.

To find it is hard in general: NP-hard (Littman, "Memoryless policies", 1994). Here everything is deterministic, so a
policy is one path, and it is found by branch and bound, see `policy_search`. Goals at which counters begin that share
no observation with earlier ones divide the search into independent parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import Behaviour, DesignPoint
from rl_design_space.learning.optimum import optimal_steps
from rl_design_space.learning.policy_search import search
from rl_design_space.learning.tables import Tables, behaviour_of, learning_tables, observation_codes

#: Assignments that a search tries for each of its parts before it is given up.
NODES = 20_000
#: Layouts whose observations are computed at a time.
_AT_A_TIME = 64


class Decisions(NamedTuple):
    """The task as a graph: its states are success counter · cells + cell, and the last one is the end.

    Attributes:
        following: (actions, states) int32, the state that each action leads to.
        steps: (actions, states) int32, the steps that it makes.
    """

    following: NDArray[np.int32]
    steps: NDArray[np.int32]


@dataclass(frozen=True)
class Memoryless:
    """What is known of the best deterministic memoryless policy of a layout.

    Attributes:
        steps: steps of the best one found; None if none was found.
        bound: fewest steps that any could need; more than the step cap if none can reach the final goal.
        max_steps: the step cap.
    """

    steps: int | None
    bound: int
    max_steps: int

    @property
    def is_exact(self) -> bool:
        """Whether the best policy was found, or it is proven that none reaches the final goal."""
        return self.steps == self.bound or not self.is_possible

    @property
    def is_possible(self) -> bool:
        """Whether a policy may reach the final goal; it does if one was found."""
        return self.bound <= self.max_steps


def decisions(tables: Tables, behaviour: Behaviour, goals: NDArray[np.int32]) -> Decisions:
    """Return the graph of a layout.

    Args:
        tables: of the design point.
        behaviour: what the actions do in this layout, by action, success counter and cell.
        goals: (n_goals,) cells.
    """
    n_goals, cells = len(goals), tables.next_cell.shape[1]
    states = n_goals * cells
    waiting = np.arange(cells, dtype=tables.next_cell.dtype)[np.newaxis]
    next_cell = np.concatenate([tables.next_cell, waiting])
    following = np.full((len(tables.limits), states + 1), states, dtype=np.int32)
    steps = np.zeros_like(following)
    for action, limit in enumerate(tables.limits):
        counter, cell = np.divmod(np.arange(states), cells)
        began = counter, cell
        made = np.zeros(states, dtype=np.int32)
        going = np.ones(states, dtype=np.bool_)
        for _ in range(min(limit, tables.rules.max_steps)):
            seen = np.minimum(counter, n_goals - 1)
            cell = np.where(going, next_cell[behaviour.steps[action, seen, cell], cell], cell)
            reached = going & (cell == goals[seen])
            counter, made = counter + reached, made + going
            seen = np.minimum(counter, n_goals - 1)
            going &= (counter < n_goals) & ~(reached & tables.rules.stop_at_sub_goal)
            going &= ~behaviour.stops[action, seen, cell]
            if behaviour.marks is not None:
                going &= behaviour.marks[seen, cell] == behaviour.marks[began]
            if not going.any():
                break
        following[action, :states] = np.where(counter < n_goals, counter * cells + cell, states)
        steps[action, :states] = made
    return Decisions(following, steps)


def best_memoryless(
    point: DesignPoint,
    tables: Tables,
    layout: NDArray[np.int32],
    codes: NDArray[np.int64],
    nodes: int = NODES,
) -> Memoryless:
    """Search the best deterministic memoryless policy of a layout.

    Args:
        point: the design point.
        tables: of the point.
        layout: (1 + n_goals,) start and goals.
        codes: (n_goals, cells) observation code in each state.
        nodes: assignments that the search tries for each of its parts.
    """
    start, goals, cells, cap = int(layout[0]), layout[1:], codes.shape[1], tables.rules.max_steps
    steps, stops, marks = behaviour_of(point, goals[np.newaxis], codes[np.newaxis])
    behaviour = Behaviour(steps[:, 0], stops[:, 0], None if marks is None else marks[0])
    graph = decisions(tables, behaviour, goals)
    row = _rows(codes)
    rows = np.append(row.ravel(), row.max() + 1).astype(np.int32)
    one_step = all(limit == 1 for limit in tables.limits)
    # Where an action may pass a goal, the next counter begins in different cells, and nothing is independent.
    divisible = one_step or tables.rules.stop_at_sub_goal
    ends = _ends(row) if divisible else [len(goals) - 1]
    found, bound, first = 0, 0, 0
    complete = True
    for last in ends:
        origin = first * cells + (start if first == 0 else int(goals[first - 1]))
        target = (last + 1) * cells + int(goals[last]) if last + 1 < len(goals) else len(goals) * cells
        needed, least = search(*graph, rows, origin, target, cap, nodes, one_step)
        complete &= needed >= 0
        found, bound, first = found + needed, bound + least, last + 1
    return Memoryless(found if complete and found <= cap else None, min(bound, cap + 1), cap)


def memoryless_steps(
    point: DesignPoint, layouts: NDArray[np.int32], with_fewer: FloatArray | None = None
) -> FloatArray:
    """Return the steps of the best deterministic memoryless policy of each layout; NaN where they are not known.

    In a stochastic world they are known only where a policy can be any.

    Args:
        point: the design point.
        layouts: (layouts, 1 + n_goals) start and goals.
        with_fewer: (layouts,) the same with some of the actions alone. Where these are enough for the optimum, nothing
            is searched: the more actions there are, the longer that takes.
    """
    tables = learning_tables(point)
    optimum = optimal_steps(tables, layouts)
    found = np.full(len(layouts), np.nan) if with_fewer is None else np.where(with_fewer == optimum, optimum, np.nan)
    left = np.flatnonzero(found != optimum)
    for first in range(0, len(left), _AT_A_TIME):
        part = left[first : first + _AT_A_TIME]
        for number, codes in zip(part.tolist(), observation_codes(point, layouts[part, 1:]), strict=True):
            if point.msa.primitives and len(np.unique(codes)) == codes.size:
                # No two states look the same, and all steps can be chosen: the policy can be any.
                found[number] = optimum[number]
                continue
            if tables.outcomes is not None:
                continue
            best = best_memoryless(point, tables, layouts[number], codes)
            if best.is_exact and best.steps is not None:
                found[number] = best.steps
    return found


def _rows(codes: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return numbers of observations, from 0."""
    numbers: NDArray[np.int32] = np.unique(codes, return_inverse=True)[1].reshape(codes.shape).astype(np.int32)
    return numbers


def _ends(row: NDArray[np.int32]) -> list[int]:
    """Return the success counters after which no observation occurs that has occurred up to them."""
    last = np.zeros(int(row.max()) + 1, dtype=np.int64)
    for counter, rows in enumerate(row):
        last[rows] = counter
    reach = np.maximum.accumulate([int(last[rows].max()) for rows in row])
    return [counter for counter, latest in enumerate(reach.tolist()) if latest == counter]
