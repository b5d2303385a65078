"""What a step leads to, and what it earns: as the tables of a world and a reward say, or by chance and by transition.

A world without chance has a transition table, and a reward that depends on the kind of cell alone has four numbers;
then there is nothing else to look up, and nothing is drawn: the functions below are called, and compiled, only where
they are needed. Their callers ask, because a look-up behind a condition in a function of its own costs a tenth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.learning.behaviour import COIN_SIDES, draw_one
from rl_design_space.learning.compiled import inlined
from rl_design_space.learning.lanes import WORD, index

_0, _32 = index(0), index(32)


class Chance(NamedTuple):
    """The outcomes of steps, in the form in which they are drawn.

    Attributes:
        cells: (cells · width, k) int32, the cells that a step may lead to, by cell and step: of four, or, if actions
            follow a table, of eight, the fifth of which is to wait.
        below: (cells · width, k - 1) uint64, probability that an outcome or one before it happens, times 2^32.
    """

    cells: NDArray[np.int32]
    below: NDArray[np.uint64]


class Pay(NamedTuple):
    """Rewards by transition, of all lanes.

    Attributes:
        rewards: (lanes · n_goals · cells · width · k,) float64, by state, step and outcome.
        of_state: width · k, uint64.
        of_step: k, uint64.
    """

    rewards: FloatArray
    of_state: np.uint64
    of_step: np.uint64


def chance_of(cells: NDArray[np.int32], probabilities: FloatArray, *, tabulated: bool) -> Chance:
    """Return the outcomes of steps in the form in which they are drawn.

    Args:
        cells: (4, cells, k), see `Outcomes`.
        probabilities: (4, cells, k), see `Outcomes`.
        tabulated: whether actions follow a table.
    """
    _, count, k = cells.shape
    width = 8 if tabulated else 4
    there = np.zeros((count, width, k), dtype=np.int32)
    there += np.arange(count, dtype=np.int32)[:, np.newaxis, np.newaxis]  # an agent that waits stays
    there[:, :4] = cells.swapaxes(0, 1)
    below = np.full((count, width, k - 1), COIN_SIDES, dtype=np.uint64)
    below[:, :4] = np.rint(np.cumsum(probabilities, axis=-1)[..., :-1] * COIN_SIDES).swapaxes(0, 1)
    return Chance(there.reshape(-1, k), below.reshape(-1, k - 1))


@inlined
def pay_of(lanes, earnings, chance, observations):
    """Return the rewards by transition; None if there are none."""
    if earnings is None:
        return None
    outcomes = 1 if chance is None else chance.cells.shape[1]
    return Pay(lanes.earnings.ravel(), index(lanes.earnings.shape[1] // observations), index(outcomes))


@inlined
def land(numbers, lane, at, chance):
    """Draw the cell that a step leads to; return it and the number of this outcome.

    Args:
        numbers: of the lanes.
        lane: that makes the step, and draws a word.
        at: cell and step.
        chance: see `Chance`.
    """
    draw_one(numbers, lane)
    coin = numbers[WORD + lane] >> _32
    outcome = _0
    for other in range(chance.below.shape[1]):
        outcome += index(coin >= chance.below[at, index(other)])
    return index(chance.cells[at, outcome]), outcome


@inlined
def earned(state, step, outcome, pay):
    """Return the reward of a step.

    Args:
        state: number of the state where it begins, of all lanes.
        step: its number.
        outcome: number of its outcome.
        pay: see `Pay`.
    """
    return pay.rewards[state * pay.of_state + step * pay.of_step + outcome]
