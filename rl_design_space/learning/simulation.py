"""Simulating a design point: from its tables to its learning curves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, cell_count, stages_of
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked import action_table, observation_codes
from rl_design_space.learning.controls import ActionTable, no_table
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.earning import earnings, width_of
from rl_design_space.learning.joint import JointLearning
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import Lanes, empty_lanes, row_width, side_by_side
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.memory import check_memory
from rl_design_space.learning.optimum import optimal_steps
from rl_design_space.learning.precision import next_stage
from rl_design_space.learning.replay import Part, check_one_stage, check_periods, checked_parts, replays
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.sequential.own import refuse_broken
from rl_design_space.learning.stages import StagedLearning
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import learning_tables

#: Observation codes computed at a time per thread: few enough to stay in the cache, enough to make up for the call.
_CODES_IN_FLIGHT = 50_000
#: Seconds that a share of the periods takes at least. To take the next one, a thread waits for the others: one of them
#: runs Python at a time, and that one may have lost its core to another process.
_SHARE_SECONDS = 0.01


def simulate(
    point: DesignPoint,
    threads: int | None = None,
    *,
    begun: LearningCurves | None = None,
    keep: Iterable[Part] = (),
    periods: Sequence[int] | None = None,
) -> LearningCurves:
    """Learn all periods of a design point; as many as its precision needs, if it asks for one.

    Args:
        point: the design point.
        threads: number of threads that learn; all available cores if None. The result does not depend on it.
        begun: a result of the same point with another number of periods, which are not learned again. The result does
            not depend on it, beside the seconds.
        keep: what to keep of the inside of periods, as `LearningCurves.inside`: `q`, the Q-matrix after the last trial;
            `history`, the Q-matrix after each trial; `visits`; `paths`. See `Replay`.
        periods: numbers of the periods that it is kept of; all if None.

    Raises:
        ValueError: `begun` is not a result of the first periods of this point.
        ConfigError: an option returns a table that violates its contract, a goal cannot be reached, or the results
            need more memory than there is; or there is no such part or period to keep.
    """
    if parts := checked_parts(keep):
        check_one_stage(point)
        check_periods(point, periods or ())
    elif periods is not None:
        raise ConfigError.at("periods", list(periods), 'says what is kept of which periods, so it needs keep=["q"]')
    stage = next_stage(point, begun)
    while isinstance(stage, DesignPoint):
        begun = _learned(stage, threads or available_threads(), begun)
        stage = next_stage(point, begun)
    return replace(stage, inside=replays(stage.point, parts, periods)) if parts else stage


def _learned(point: DesignPoint, threads: int, begun: LearningCurves | None) -> LearningCurves:
    """Learn a fixed number of periods."""
    learning = learning_of(point, threads, begun)
    with ThreadPoolExecutor(threads) as pool:
        for _ in range(threads - 1):
            pool.submit(learning.work)
        try:
            learning.work()
        except BaseException:
            learning.stop()
            raise
    return learning.curves()


def learning_of(point: DesignPoint, threads: int = 1, begun: LearningCurves | None = None) -> JointLearning:
    """Return the learning of a fixed number of periods, which several threads can join.

    Args:
        point: the design point.
        threads: expected number of threads. The result depends neither on it nor on the actual number.
        begun: a result of the same point with fewer periods, which are not learned again.

    Raises:
        ValueError: `begun` is not a result of the first periods of this point.
        ConfigError: an option returns a table that violates its contract, a goal cannot be reached, or the results
            need more memory than there is.
    """
    stages = stages_of(point)
    return StagedLearning(point, stages, threads, begun) if stages else Learning(point, threads, begun)


class Learning(JointLearning):
    """The learning of a fixed number of periods of one stage.

    Args:
        point: the design point.
        threads: expected number of threads. The result depends neither on it nor on the actual number.
        begun: a result of the same point with fewer periods, which are not learned again.

    Raises:
        ValueError: `begun` is not a result of the first periods of this point.
        ConfigError: an option returns a table that violates its contract, a goal cannot be reached, or the results
            need more memory than there is.
    """

    def __init__(self, point: DesignPoint, threads: int = 1, begun: LearningCurves | None = None) -> None:
        super().__init__(task := point.task, begun)
        cells = cell_count(point.world)
        check_memory(task)
        self._point = point
        self._tables = learning_tables(point)
        self._layouts = layouts_of(point)
        self._optimum = optimal_steps(self._tables, self._layouts)
        self._generator = behaviour_states(point.seed, task.periods)
        self._steps = np.empty((task.periods, task.trials), dtype=np.int32)
        self._success = np.empty((task.periods, task.trials), dtype=np.bool_)
        self._rows = np.empty((task.periods, 2), dtype=np.int32)
        first = self._copy(begun) if begun else 0
        self._observations, width = task.goals * cells, row_width(len(self._tables.limits))
        self._no_earnings = earnings(point, self._tables, self._layouts[:0, 1:])
        bytes_each = (8 if point.msa.repeats else 12) * self._observations * width + 8 * width_of(self._no_earnings)
        self._lanes = side_by_side(task.periods - first, threads, bytes_each)
        self._nothing = np.empty((0, task.goals, cells), dtype=np.int64)
        self._no_table = None if point.msa.repeats else no_table(self._observations, len(self._tables.limits))
        # Without periods: this compiles, or loads compiled code, outside the measured time.
        self._learn(self._nothing, self._no_table, self._no_earnings, 0, self._empty_lanes(1), drain=True)
        parts, most = 2 * threads if threads > 1 else 1, max(1, _CODES_IN_FLIGHT // self._observations)
        self.begin(first, lambda left, least: min(max(left // parts, self._lanes, least), most))

    def curves(self) -> LearningCurves:
        """Return the result, after the learning is complete.

        Raises:
            Exception: the error that stopped the learning.
        """
        seconds = self.seconds()
        refuse_broken(self._point, self._rows)
        return LearningCurves(
            self._steps, self._success, self._optimum, self._rows, self._tables.epsilon, seconds, self._point,
            ended_at=self.ended_at,
        )  # fmt: skip

    def _copy(self, begun: LearningCurves) -> int:
        """Copy the result of the first periods; return their number."""
        first = self.check(begun, self._optimum, self._tables.epsilon)
        self._steps[:first], self._success[:first], self._rows[:first] = begun.steps, begun.success, begun.rows
        return first

    def _work(self) -> None:
        """Learn shares until none is left; their periods overlap, so that no lane is idle in between.

        The last shares are small, so that all threads end at about the same time, however long single periods take.
        """
        lanes, least = self._empty_lanes(self._lanes), 1
        started, taken = perf_counter(), 0
        while (share := self.next_share(least)) is not None:
            goals = self._layouts[share, 1:]
            codes = observation_codes(self._point, goals)
            paid = earnings(self._point, self._tables, goals)
            self._learn(codes, action_table(self._point, goals, codes), paid, share.start, lanes, drain=False)
            taken += len(goals)
            least = int(taken * _SHARE_SECONDS / (perf_counter() - started))
        self._learn(self._nothing, self._no_table, self._no_earnings, 0, lanes, drain=True)

    def _empty_lanes(self, lanes: int) -> Lanes:
        return empty_lanes(
            lanes,
            self._observations,
            self._tables.limits,
            tabulated=self._no_table is not None,
            drawn=self._tables.chance is not None,
            earnings=width_of(self._no_earnings),
        )

    def _learn(
        self,
        codes: NDArray[np.int64],
        table: ActionTable | None,
        paid: FloatArray | None,
        first: int,
        lanes: Lanes,
        *,
        drain: bool,
    ) -> None:
        tables = self._tables
        learn(
            tables.next_cell, tables.limits, tables.threshold, tables.rules, codes, first, self._layouts,
            self._generator, lanes, drain, self._steps, self._success, self._rows, table, None,
            tables.chance, paid, tables.method,
        )  # fmt: skip
