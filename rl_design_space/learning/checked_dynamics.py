"""What steps lead to and earn: transitions, outcomes, potentials and rewards of transitions, validated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space.design import (
    DesignPoint,
    Outcomes,
    PotentialReward,
    StochasticWorld,
    TransitionReward,
    cell_count,
)
from rl_design_space.design.identity import full_name
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked_table import LARGEST, checked_table

#: Probabilities add up to 1 but for rounding.
_SUM_TOLERANCE = 1e-9


def transitions(point: DesignPoint) -> NDArray[np.int32]:
    """Return the transition table of the world: (4, cells) int32, the cell that each step leads to.

    In a stochastic world, where it leads if nothing goes astray; or where it always leads, if nothing can.

    Raises:
        ConfigError: the world returns a table of the wrong shape, type or range.
    """
    cells = cell_count(point.world)
    table = checked_table(
        "world", point.world, "next_cell", point.world.next_cell(), (4, cells), np.int32, 0, cells - 1
    )
    if isinstance(point.world, StochasticWorld):
        found = _outcomes(point)
        if _is_certain(found):
            certain = found.probabilities.argmax(axis=-1)[..., np.newaxis]
            return np.ascontiguousarray(np.take_along_axis(found.cells, certain, axis=-1)[..., 0])
    return table


def outcomes(point: DesignPoint) -> Outcomes | None:
    """Return what each step may lead to; None if there is no chance in it.

    Raises:
        ConfigError: the world returns tables of the wrong shape, type or range.
    """
    if not isinstance(point.world, StochasticWorld):
        return None
    found = _outcomes(point)
    return None if _is_certain(found) else found


def _is_certain(found: Outcomes) -> bool:
    return bool(np.isin(found.probabilities, (0, 1)).all())


def _outcomes(point: DesignPoint) -> Outcomes:
    world, cells, name = point.world, cell_count(point.world), full_name(type(point.world))
    assert isinstance(world, StochasticWorld)
    found = world.outcomes()
    if not isinstance(found, tuple) or len(found) != 2:
        raise ConfigError(f"world: {name}.outcomes() should give two arrays: cells, and their probabilities")
    last = found[0].shape[-1] if isinstance(found[0], np.ndarray) and found[0].ndim == 3 else 1
    shape = (4, cells, last)
    there = checked_table("world", world, "outcomes", found[0], shape, np.int32, 0, cells - 1)
    shares = checked_table("world", world, "outcomes", found[1], shape, np.float64, 0, 1)
    sums = shares.sum(axis=-1)
    if (np.abs(sums - 1) > _SUM_TOLERANCE).any():
        step, cell = np.argwhere(np.abs(sums - 1) > _SUM_TOLERANCE)[0]
        raise ConfigError(
            f"world: {name}.outcomes(): probabilities should add up to 1; those of step {step} from cell {cell} add "
            f"up to {sums[step, cell]:.9g}"
        )
    return Outcomes(there, shares)


def potential(point: DesignPoint, goals: IntArray) -> FloatArray | None:
    """Return the potential of every state in several periods, (periods, n_goals, cells); None if nothing is shaped.

    Raises:
        ConfigError: the reward returns an array of the wrong shape, type or range.
    """
    reward = point.reward
    if not isinstance(reward, PotentialReward):
        return None
    shape = (*goals.shape, cell_count(point.world))
    found = reward.potential(point.world, goals)
    return checked_table("reward", reward, "potential", found, shape, np.float64, -LARGEST, LARGEST)


def by_transition(point: DesignPoint, goals: IntArray, n_outcomes: int) -> FloatArray | None:
    """Return what each step earns beside the table of rewards, (periods, n_goals, 4, cells, 1 or n_outcomes).

    None if it earns nothing besides.

    Raises:
        ConfigError: the reward returns an array of the wrong shape, type or range.
    """
    reward = point.reward
    if not isinstance(reward, TransitionReward):
        return None
    found = reward.by_transition(point.world, goals)
    shape: tuple[int, ...] = (*goals.shape, 4, cell_count(point.world))
    by_outcome = isinstance(found, np.ndarray) and found.ndim == len(shape) + 1 and n_outcomes > 1
    shape = (*shape, n_outcomes) if by_outcome else shape
    checked_table("reward", reward, "by_transition", found, shape, np.float64, -LARGEST, LARGEST)
    return found if by_outcome else found[..., np.newaxis]
