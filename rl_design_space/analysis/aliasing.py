"""Perceptual aliasing of a representation: what is lost where states share an observation (paper, Table 1)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import QLearning, Representation, Reward, World, open_cells, refuse_chance
from rl_design_space.errors import ConfigError
from rl_design_space.learning.earning import is_paid
from rl_design_space.learning.optimal_values import optimal_values


class Aliasing(NamedTuple):
    """Three measures of aliasing on one layout, all of them 0 where every state has an observation of its own.

    States x are pairs of success counter and cell in which the agent can choose a step: all open cells but that of the
    due goal, where the counter would have increased. All states count the same, and so do the steps a. o(x) is the
    observation, x' the state that a step leads to; the end of a trial counts as an observation.

    Attributes:
        next_unknown: conditional entropy of the next observation given observation and step, in bits,
            H(O' | O, A) = - Σ p(o, a, o') log2 p(o' | o, a). It is 0 where the next observation follows from both, and
            does not always grow as observations are merged: with a single observation only the end is uncertain.
        value_lost: share of the variance of the optimal Q-values that is lost by merging the states of an observation,
            Σ_x,a (Q*(x, a) - mean of Q*(y, a) over y with o(y) = o(x))² / Σ_x,a (Q*(x, a) - mean of Q*(·, a))².
        shared: share of states that share their observation with another state, |{x : o(y) = o(x), y ≠ x}| / |{x}|.
    """

    next_unknown: float
    value_lost: float
    shared: float


def aliasing_by_layout(
    representation: Representation, world: World, layouts: NDArray[np.int32], reward: Reward, learner: QLearning
) -> dict[str, FloatArray]:
    """Return the fields of `Aliasing` on each layout, (layouts,) each.

    Args:
        representation: the representation.
        world: world of the layouts.
        layouts: (layouts, 1 + n_goals) starts and goals.
        reward: rewards of the task.
        learner: its discount factor, and its reward of goals that are not due.

    Raises:
        ConfigError: the world is stochastic, or rewards depend on the transition.
    """
    refuse_chance(world, "measures of aliasing")
    if is_paid(reward):
        raise ConfigError("reward: measures of aliasing are known for rewards of the kind of step alone")
    goals, rewards = layouts[:, 1:], reward.table()
    codes = representation.observation(world, goals)
    out_of_order = float(rewards[0]) if learner.out_of_order == "step_reward" else 0.0
    values = optimal_values(world.next_cell(), goals, rewards, learner.gamma, out_of_order)
    each = [aliasing(world, *of) for of in zip(goals, codes, values.swapaxes(0, 1), strict=True)]
    return {name: np.array(numbers) for name, numbers in zip(Aliasing._fields, zip(*each, strict=True), strict=True)}


def aliasing(world: World, goals: NDArray[np.int32], codes: NDArray[np.int64], optimal_values: FloatArray) -> Aliasing:
    """Return the aliasing of a representation on one layout.

    Args:
        world: the world.
        goals: (n_goals,) cells, to be reached in this order.
        codes: (n_goals, cells) observations, by success counter.
        optimal_values: (4, n_goals, cells) optimal Q-values.
    """
    counters, cells = _states(world, goals)
    known, which, counts = np.unique(codes[counters, cells], return_inverse=True, return_counts=True)
    values = optimal_values[:, counters, cells]
    merged = np.array([np.bincount(which, each) for each in values]) / counts
    variance = np.square(values - values.mean(axis=1, keepdims=True)).sum()
    lost = np.square(values - merged[:, which]).sum()
    after = _next_observations(world, goals, codes, known, counters, cells)
    return Aliasing(
        next_unknown=float(np.mean([_conditional_entropy(which, each) for each in after])),
        value_lost=float(lost / variance) if variance else 0.0,
        shared=float((counts[which] > 1).mean()),
    )


def _states(world: World, goals: NDArray[np.int32]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return success counter and cell of each state, (states,) each."""
    possible = np.zeros((len(goals), world.next_cell().shape[1]), dtype=np.bool_)
    possible[:, open_cells(world)] = True
    possible[np.arange(len(goals)), goals] = False
    counters, cells = np.nonzero(possible)
    return counters, cells


def _next_observations(
    world: World,
    goals: NDArray[np.int32],
    codes: NDArray[np.int64],
    known: NDArray[np.int64],
    counters: NDArray[np.intp],
    cells: NDArray[np.intp],
) -> NDArray[np.intp]:
    """Return which of `known` follows each step in each state, (4, states); the number of them where the trial ends."""
    there = world.next_cell()[:, cells]
    then = counters + (there == goals[counters])
    ended = then == len(goals)
    seen = codes[np.where(ended, 0, then), there]
    return np.where(ended, len(known), np.searchsorted(known, seen))


def _conditional_entropy(given: NDArray[np.intp], of: NDArray[np.intp]) -> float:
    """Return the entropy in bits of one variable given another; every pair of values counts the same."""
    _, pairs = np.unique(given * (of.max(initial=0) + 1) + of, return_counts=True)
    _, alone = np.unique(given, return_counts=True)
    return float((alone @ np.log2(alone) - pairs @ np.log2(pairs)) / len(given))
