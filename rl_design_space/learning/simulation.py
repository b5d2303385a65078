"""From a design point to its learning curves."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import DesignPoint, cell_count
from rl_design_space.learning.curves import LearningCurves
from rl_design_space.learning.kernel import COIN_SIDES, Rules, learn
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import behaviour_states, layouts

#: Observation codes held at a time, per thread: periods in flight are cut so that memory grows with the world only.
_CODES_IN_FLIGHT = 250_000
#: Shares of the periods that each thread gets, so that a share with slow periods leaves no core idle for long.
_SHARES_PER_THREAD = 16


def available_threads() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def simulate(point: DesignPoint, threads: int | None = None) -> LearningCurves:
    """Learn all periods of a design point.

    Args:
        point: what to learn.
        threads: how many learn at the same time; all available cores if None. The result does not depend on it.

    Raises:
        ValueError: an option yields a table that does not fit its contract, or a goal cannot be reached.
    """
    threads = threads or available_threads()
    task, cells = point.task, cell_count(point.world)
    next_cell = point.world.next_cell()
    layout = layouts(point.seed, cells, task.goals, task.periods)
    generator = behaviour_states(point.seed, task.periods)
    epsilon = point.exploration.schedule(task.trials)
    threshold = np.rint(epsilon * COIN_SIDES).astype(np.uint64)
    lengths = tuple(point.msa.table().tolist())
    rules = _rules(point)
    steps = np.empty((task.periods, task.trials), dtype=np.int32)
    success = np.empty((task.periods, task.trials), dtype=np.bool_)

    def learn_share(share: slice) -> None:
        learn_rows(share, *q_rows(point.representation.observation(point.world, layout[share, 1:])))

    def learn_rows(share: slice, observation: NDArray[np.int32], n_rows: int) -> None:
        q = np.empty((n_rows, 4 * len(lengths)))
        learn(
            next_cell, observation, layout[share], threshold, lengths, rules, generator[share], q,
            steps[share], success[share],
        )  # fmt: skip

    # No period at all: compiles, or loads what was compiled, outside the measured time.
    learn_rows(slice(0, 0), np.empty((0, task.goals, cells), dtype=np.int32), 0)
    started = perf_counter()
    size = max(1, min(task.periods // (threads * _SHARES_PER_THREAD), _CODES_IN_FLIGHT // (task.goals * cells)))
    shares = [slice(first, first + size) for first in range(0, task.periods, size)]
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(learn_share, shares))
    seconds = perf_counter() - started
    return LearningCurves(steps, success, shortest_tours(next_cell, layout), epsilon, seconds)


def q_rows(codes: NDArray[np.int64]) -> tuple[NDArray[np.int32], int]:
    """Number the observation codes that occur in a period 0, 1, 2, … in the order of their values.

    A period meets at most n_goals · cells observations, however many codes there are.

    Args:
        codes: (periods, n_goals, cells).

    Returns:
        Rows of the Q-matrix, (periods, n_goals, cells) int32, and the largest number of rows of a period.
    """
    flat = codes.reshape(len(codes), -1)
    order = np.argsort(flat, axis=1, kind="stable")
    ordered = np.take_along_axis(flat, order, axis=1)
    ranks = np.zeros(flat.shape, dtype=np.int32)
    np.cumsum(ordered[:, 1:] != ordered[:, :-1], axis=1, out=ranks[:, 1:])
    rows = np.empty_like(ranks)
    np.put_along_axis(rows, order, ranks, axis=1)
    return rows.reshape(codes.shape), int(ranks[:, -1].max()) + 1


def _rules(point: DesignPoint) -> Rules:
    learner, msa = point.learner, point.msa
    step, sub_goal, final_goal = point.reward.table().tolist()
    propagated = {"none": 0, "primitives": 1, "all_shorter": 1 + len(msa.lengths)}
    return Rules(
        alpha=learner.alpha,
        gamma=learner.gamma,
        initial_q=learner.initial_q,
        step_reward=step,
        sub_goal_reward=sub_goal,
        final_goal_reward=final_goal,
        out_of_order_reward=step if learner.out_of_order == "step_reward" else 0.0,
        explore_all=learner.explore == "all",
        first_maximum=learner.ties == "first",
        printed_update=learner.update == "printed",
        printed_msa_reward=msa.reward == "printed",
        stop_at_sub_goal=msa.sub_goal == "stop",
        propagated_lengths=propagated[msa.propagation],
        max_steps=point.task.max_steps,
    )
