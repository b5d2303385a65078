"""Properties of a representation that follow from its observations, without learning (paper, Table 1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import Representation, World, refuse_chance
from rl_design_space.learning.optimum import shortest_tours


@dataclass(frozen=True)
class Properties:
    """Properties of a representation on some layouts, means over the layouts.

    A state is a cell and a success counter.

    Attributes:
        states_each: mean number of states with the same observation as a state, itself included.
        aliased: share of states with an observation for which no step is optimal in all states that have it.
        other_goals: share of states of another layout in which the step is optimal that is optimal most often for the
            same observation in a first layout; an observation that does not occur in the first layout counts as a
            failure. A random step is optimal in about half of the states.
        larger_grid: as `other_goals`, for a layout on a larger grid.
    """

    states_each: float
    aliased: float
    other_goals: float
    larger_grid: float


@dataclass(frozen=True)
class Places:
    """Layouts in a world, with the optimal steps, which all representations share.

    Attributes:
        world: the world.
        layouts: (layouts, 1 + n_goals) starts and goals.
        optimal: of each layout, see `optimal_moves`.
    """

    world: World
    layouts: NDArray[np.int32]
    optimal: Sequence[NDArray[np.bool_]]

    @classmethod
    def of(cls, world: World, layouts: NDArray[np.int32]) -> Places:
        """Return layouts with their optimal steps."""
        return cls(world, layouts, [optimal_moves(world, layout[1:]) for layout in layouts])


@dataclass(frozen=True)
class _Layout:
    """Observations and optimal steps in a layout.

    Attributes:
        codes: (n_goals, cells) observations, by success counter.
        optimal: (4, n_goals, cells) whether the step in each direction is optimal.
    """

    codes: NDArray[np.int64]
    optimal: NDArray[np.bool_]

    @cached_property
    def votes(self) -> _Votes:
        """For which steps the states of each observation vote."""
        known, which, counts = np.unique(self.codes.ravel(), return_inverse=True, return_counts=True)
        votes = [np.bincount(which[optimal.ravel()], minlength=len(known)) for optimal in self.optimal]
        return _Votes(known, which, counts, np.stack(votes, axis=1))


class _Votes(NamedTuple):
    """For which steps the states of each observation vote: those that are optimal in them.

    Attributes:
        known: (observations,) the observations.
        which: (states,) index of the observation of each state.
        counts: (observations,) number of states of each.
        votes: (observations, 4) number of states where each step is optimal.
    """

    known: NDArray[np.int64]
    which: NDArray[np.intp]
    counts: NDArray[np.int64]
    votes: NDArray[np.intp]


def properties(
    representation: Representation,
    world: World,
    larger: World,
    layouts: NDArray[np.int32],
    on_larger: NDArray[np.int32],
) -> Properties:
    """Return the properties of a representation.

    Args:
        representation: the representation.
        world: world of the layouts.
        larger: a larger world.
        layouts: (layouts, 1 + n_goals) starts and goals in `world`, at least two.
        on_larger: (layouts, 1 + n_goals) starts and goals in `larger`.
    """
    each = properties_by_layout(representation, Places.of(world, layouts), Places.of(larger, on_larger))
    return Properties(**{name: float(values.mean()) for name, values in each.items()})


def properties_by_layout(representation: Representation, places: Places, larger: Places) -> dict[str, FloatArray]:
    """Return the fields of `Properties` on each layout, (layouts,) each; see `properties`."""
    seen, beyond = _look(representation, places), _look(representation, larger)
    alone = np.array([_of_layout(each) for each in seen])
    return {
        "states_each": alone[:, 0],
        "aliased": alone[:, 1],
        "other_goals": np.array([_carried(*pair) for pair in zip(seen, seen[1:] + seen[:1], strict=True)]),
        "larger_grid": np.array([_carried(*pair) for pair in zip(seen, beyond, strict=True)]),
    }


def optimal_moves(world: World, goals: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return which steps bring the agent nearer to the due goal.

    Args:
        world: the world.
        goals: (n_goals,) cells, to be reached in this order.

    Returns:
        (4, n_goals, cells), by direction, success counter and cell; at the goal itself every step is optimal.
    """
    refuse_chance(world, "the steps that bring the agent nearer to a goal")
    next_cell = world.next_cell()
    cells = np.arange(next_cell.shape[1], dtype=np.int32)
    pairs = np.stack(np.broadcast_arrays(cells, goals[:, np.newaxis]), axis=-1).reshape(-1, 2).astype(np.int32)
    away: NDArray[np.int32] = shortest_tours(next_cell, pairs).reshape(len(goals), len(cells))
    nearer = away[:, next_cell].transpose(1, 0, 2) < away
    at_goal = np.equal(goals[:, np.newaxis], cells)
    return np.asarray(np.logical_or(nearer, at_goal))


def _look(representation: Representation, places: Places) -> list[_Layout]:
    codes = representation.observation(places.world, places.layouts[:, 1:])
    return [_Layout(*each) for each in zip(codes, places.optimal, strict=True)]


def _of_layout(layout: _Layout) -> tuple[float, float]:
    """Return the mean number of states with equal observations, and the share of aliased states."""
    _, which, counts, votes = layout.votes
    agreed = (votes == counts[:, np.newaxis]).any(axis=1)
    return float(counts[which].mean()), float((~agreed[which]).mean())


def _carried(known_from: _Layout, to: _Layout) -> float:
    """Return how often the best step for an observation in one layout is optimal in another."""
    known, _, _, votes = known_from.votes
    codes = to.codes.ravel()
    place = np.minimum(np.searchsorted(known, codes), len(known) - 1)
    move = votes.argmax(axis=1)[place]
    optimal = to.optimal.reshape(len(to.optimal), -1)[move, np.arange(len(codes))]
    return float((optimal & (known[place] == codes)).mean())
