"""From a design point to its learning curves."""

from __future__ import annotations

import os
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import DesignPoint, cell_count
from rl_design_space.learning.curves import LearningCurves
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import LANES, WIDTH, Lanes, empty_lanes
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import behaviour_states, layouts
from rl_design_space.learning.tables import learning_tables, observation_codes

#: Observation codes made at a time, per thread: few enough to stay in the cache, enough that a call is worth its cost.
_CODES_IN_FLIGHT = 24_000
#: Bytes that the Q-matrices of all lanes of a thread may take, so that they stay in a processor's cache; lanes that
#: it takes even so, lest every decision wait for the last one; and bytes that they may take at all.
_CACHED_BYTES, _ENOUGH_LANES, _LARGEST_BYTES = 2**22, 6, 2**28


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
    tables = learning_tables(point)
    layout = layouts(point.seed, cells, task.goals, task.periods)
    optimum = shortest_tours(tables.next_cell, layout)
    generator = behaviour_states(point.seed, task.periods)
    steps = np.empty((task.periods, task.trials), dtype=np.int32)
    success = np.empty((task.periods, task.trials), dtype=np.bool_)
    observations, n_actions = task.goals * cells, 4 * len(tables.lengths)
    side_by_side = _side_by_side(task.periods, threads, bytes_each=8 * observations * n_actions)
    shares = deque(_shares(task.periods, threads, side_by_side, observations))

    none = np.empty((0, task.goals, cells), dtype=np.int64)

    def learn_on(codes: NDArray[np.int64], first: int, lanes: Lanes, *, drain: bool) -> None:
        learn(
            tables.next_cell, tables.lengths, tables.threshold, tables.rules, codes, first, layout, generator, lanes,
            drain, steps, success,
        )  # fmt: skip

    def learn_shares() -> None:
        """Take up shares until none is left; their periods overlap, so that no lane is empty in between."""
        lanes = empty_lanes(side_by_side, observations, tables.lengths)
        try:
            while (share := _next(shares)) is not None:
                learn_on(observation_codes(point, layout[share, 1:]), share.start, lanes, drain=False)
            learn_on(none, 0, lanes, drain=True)
        except BaseException:
            shares.clear()
            raise

    # No period at all: compiles, or loads what was compiled, outside the measured time.
    learn_on(none, 0, empty_lanes(1, observations, tables.lengths), drain=True)
    started = perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        others = [pool.submit(learn_shares) for _ in range(threads - 1)]
        learn_shares()
        for learned in others:
            learned.result()
    return LearningCurves(steps, success, optimum, tables.epsilon, seconds=perf_counter() - started)


def _next(shares: deque[slice]) -> slice | None:
    """Take a share; asking first whether there is one would let another thread take it in between."""
    try:
        return shares.popleft()
    except IndexError:
        return None


def _side_by_side(periods: int, threads: int, bytes_each: int) -> int:
    """How many periods each thread learns at a time."""
    cached = min(LANES, _CACHED_BYTES // bytes_each)
    lanes = max(_ENOUGH_LANES, cached - cached % WIDTH)
    return max(1, min(lanes, _LARGEST_BYTES // bytes_each, -(-periods // threads)))


def _shares(periods: int, threads: int, side_by_side: int, codes_each: int) -> list[slice]:
    """Cut the periods into shares for threads that take the next one whenever they have a free lane.

    The last shares are small, so that all threads end at about the same time, however long single periods take.
    """
    shares, first = [], 0
    while first < periods:
        even = (periods - first) // (2 * threads if threads > 1 else 1)
        size = min(max(even, side_by_side), max(1, _CODES_IN_FLIGHT // codes_each))
        shares.append(slice(first, min(first + size, periods)))
        first += size
    return shares
