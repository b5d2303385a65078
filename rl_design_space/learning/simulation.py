"""From a design point to its learning curves."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import DesignPoint, cell_count
from rl_design_space.learning.curves import LearningCurves
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.streams import behaviour_states, layouts
from rl_design_space.learning.tables import learning_tables, observation_rows

#: Observation codes held at a time, per thread: periods in flight are cut so that memory grows with the world only.
_CODES_IN_FLIGHT = 250_000
#: Shares of the periods that each of several threads gets, so that one with slow periods leaves no core idle for
#: long; a share has this many periods at least, because each costs some time of its own.
_SHARES_PER_THREAD, _PERIODS_PER_SHARE = 16, 8


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

    def learn_share(share: slice) -> None:
        learn_rows(share, *observation_rows(point, layout[share, 1:]))

    def learn_rows(share: slice, rows: NDArray[np.int32], n_rows: int) -> None:
        q = np.empty((n_rows, 4 * len(tables.lengths)))
        learn(
            tables.next_cell, rows, layout[share], tables.threshold, tables.lengths, tables.rules,
            generator[share], q, steps[share], success[share],
        )  # fmt: skip

    # No period at all: compiles, or loads what was compiled, outside the measured time.
    learn_rows(slice(0, 0), np.empty((0, task.goals, cells), dtype=np.int32), 0)
    started = perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(learn_share, _shares(task.periods, threads, codes_per_period=task.goals * cells)))
    return LearningCurves(steps, success, optimum, tables.epsilon, seconds=perf_counter() - started)


def _shares(periods: int, threads: int, codes_per_period: int) -> list[slice]:
    """Cut the periods into shares that are learned one after the other or at the same time."""
    even = periods if threads == 1 else max(_PERIODS_PER_SHARE, periods // (threads * _SHARES_PER_THREAD))
    size = max(1, min(even, _CODES_IN_FLIGHT // codes_per_period))
    return [slice(first, first + size) for first in range(0, periods, size)]
