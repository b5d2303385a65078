"""Learning periods of several stages, which share a Q-matrix and a random stream (docs/decisions/0030-stages.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, SizedRepresentation, StagePoint, cell_count
from rl_design_space.learning.carrying import (
    Memory,
    empty_memory,
    inherit,
    number_rows,
    recall,
    remember,
    same_place,
)
from rl_design_space.learning.checked import action_table, ancestors, observation_codes, portable_codes
from rl_design_space.learning.controls import ActionTable, no_table
from rl_design_space.learning.earning import earnings, width_of
from rl_design_space.learning.joint import JointLearning
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import empty_lanes, row_width, side_by_side
from rl_design_space.learning.memory import check_memory
from rl_design_space.learning.optimum import optimal_steps
from rl_design_space.learning.refining import refine_into
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.sequential.own import refuse_broken
from rl_design_space.learning.stage_layouts import StageScene, stage_layouts
from rl_design_space.learning.stage_record import StageRecord, bounds
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import learning_tables
from rl_design_space.learning.td_errors import Errors, no_errors

#: Bytes of the Q-matrices of the periods that a thread takes through all stages at a time.
_SHARE_BYTES = 2**27
#: Observation codes computed at a time.
_CODES_IN_FLIGHT = 24_000


class StagedLearning(JointLearning):
    """The learning of a design point whose periods have several stages.

    A thread takes a share of the periods through all stages. Q-matrices and random generators of its periods are kept
    from one stage to the next, see `Lanes`.

    Args:
        point: the design point.
        stages: its stages.
        threads: expected number of threads. The result depends neither on it nor on the actual number.
        begun: a result of the same point with fewer periods, which are not learned again.

    Raises:
        ValueError: `begun` is not a result of the first periods of this point.
        ConfigError: an option returns a table that violates its contract, a goal cannot be reached, or the results
            need more memory than there is.
    """

    def __init__(
        self,
        point: DesignPoint,
        stages: Sequence[StagePoint],
        threads: int = 1,
        begun: LearningCurves | None = None,
    ) -> None:
        super().__init__(point.task, begun)
        check_memory(replace(point.task, trials=sum(stage.point.task.trials for stage in stages)))
        self._point = point
        following = [*stages[1:], None]
        self._stages = [_Stage(*each) for each in zip(stages, stage_layouts(point, stages), following, strict=True)]
        self._generator = behaviour_states(point.seed, point.task.periods)
        self._met = _most_observations(stages)
        # Without periods: this compiles, or loads compiled code, outside the measured time.
        self._learn(slice(0, 0))
        values = self._met * self._stages[0].width + 3 * max(stage.values for stage in self._stages)
        first = self._copy(begun) if begun else 0
        self.begin(_shares(first, point.task.periods, threads, most=max(1, _SHARE_BYTES // (8 * values))))

    def curves(self) -> LearningCurves:
        """Return the result, after the learning is complete; its optimum and rows are those of the last stage.

        Raises:
            Exception: the error that stopped the learning.
        """
        seconds, last = self.seconds(), self._stages[-1]
        for stage in self._stages:
            refuse_broken(stage.point, stage.rows)
        return LearningCurves(
            steps=np.concatenate([stage.steps for stage in self._stages], axis=1),
            success=np.concatenate([stage.success for stage in self._stages], axis=1),
            optimum=last.optimum,
            rows=last.rows,
            epsilon=self._epsilon(),
            seconds=seconds,
            ended_at=self.ended_at,
            known_point=self._point,
            stages=tuple(stage.record() for stage in self._stages),
        )

    def _copy(self, begun: LearningCurves) -> int:
        """Copy the result of the first periods; return their number."""
        first = self.check(begun, self._stages[-1].optimum, self._epsilon())
        if len(begun.stages) != len(self._stages):
            raise ValueError(f"begun: a result of {len(begun.stages)} stages, not {len(self._stages)}")
        for stage, record, trials in zip(self._stages, begun.stages, bounds(begun.stages), strict=True):
            stage.steps[:first], stage.success[:first] = begun.steps[:, trials], begun.success[:, trials]
            stage.rows[:first], stage.carried[:first] = record.rows, record.carried
        return first

    def _epsilon(self) -> FloatArray:
        return np.concatenate([stage.tables.epsilon for stage in self._stages])

    def _work(self) -> None:
        while (share := self.next_share()) is not None:
            self._learn(share)

    def _learn(self, share: slice) -> None:
        """Learn all stages of a share of the periods."""
        generator = self._generator[share].copy()
        memory: Memory | None = None
        before: _Played | None = None
        for stage in self._stages:
            now = _Played(stage, share, generator, before)
            if before is None or stage.carry == "none":
                now.begin_anew()
            elif stage.carry != "same_observation":
                now.begin_with_ancestors(before)
            elif now.observes_the_same_as(before):
                now.begin_where_ended(before)
            else:
                memory = memory or empty_memory(len(generator), self._met, stage.width)
                now.begin_with_memory(memory, before)
            memory = memory if stage.carry == "same_observation" else None
            now.learn()
            if self.is_stopped:
                return
            before = now


class _Stage:
    """A stage of a point: its tables, and what all threads write of it.

    Args:
        stage: the stage.
        layouts: (periods, 1 + n_goals) start and goals.
        following: the next stage; None of the last one.
    """

    def __init__(self, stage: StagePoint, layouts: NDArray[np.int32], following: StagePoint | None) -> None:
        point: DesignPoint = stage.point
        self.point, self.carry, self.refine, self.layouts = point, stage.carry, stage.refine, layouts
        #: Whether the next stage asks for the TD errors of this one.
        self.collects = bool(following and following.refine and following.refine.split == "disagreeing")
        self.tables = learning_tables(point)
        self.optimum = optimal_steps(self.tables, layouts)
        self.width, self.states = row_width(len(self.tables.limits)), point.task.goals * cell_count(point.world)
        self.values = self.states * self.width
        shape = (len(layouts), point.task.trials)
        self.steps, self.success = np.empty(shape, dtype=np.int32), np.empty(shape, dtype=np.bool_)
        self.rows = np.empty((len(layouts), 2), dtype=np.int32)
        self.carried = np.zeros(len(layouts), dtype=np.int32)

    def record(self) -> StageRecord:
        """Return what the result says of this stage."""
        shape = self.point.world.shape
        side = float(shape[0]) if shape[0] == shape[1] else math.nan
        return StageRecord(self.point.task.trials, side, self.optimum, self.rows, self.carried)


class _Played:
    """A stage of a share of the periods.

    Args:
        stage: the stage.
        share: the periods.
        generator: (taken, 4) uint64, states of their random generators, modified in place.
        before: the stage before, if any.
    """

    def __init__(self, stage: _Stage, share: slice, generator: NDArray[np.uint64], before: _Played | None) -> None:
        self._stage, self._share, taken = stage, share, len(generator)
        self._layouts, self._generator = stage.layouts[share], generator
        self._batches = list(_batches(taken, stage.states))
        #: Observation codes, (taken, n_goals, cells) int64.
        self._codes = np.empty((taken, stage.point.task.goals, cell_count(stage.point.world)), dtype=np.int64)
        if stage.refine and before:
            refine_into(self._codes, before._rows, stage.point.world.shape[0], stage.refine, before._errors)
        else:
            for batch in self._batches if taken else ():
                self._codes[batch] = portable_codes(stage.point, self._layouts[batch, 1:])
        self._errors: Errors = no_errors(taken if stage.collects else 0, stage.states, len(stage.tables.limits))
        self._carried = stage.carried[share]
        self._kept: FloatArray = np.empty((0, 0))

    @cached_property
    def _rows(self) -> NDArray[np.int64]:
        """Rows of the Q-matrices by state, (taken, n_goals, cells) int64."""
        rows = np.empty_like(self._codes)
        number_rows(self._codes, rows)
        return rows

    def observes_the_same_as(self, before: _Played) -> bool:
        """Return whether all observations are those of another stage, state by state."""
        return len(self._codes) > 0 and np.array_equal(self._codes, before._codes)

    def begin_anew(self) -> None:
        """Begin with initial values."""
        self._kept = np.full((len(self._codes), self._stage.values), self._stage.tables.rules.initial_q)

    def begin_where_ended(self, before: _Played) -> None:
        """Begin with the Q-matrices that a stage of equal observations has ended with."""
        self._kept = before._kept
        self._carried[:] = before._stage.rows[self._share, 0]

    def begin_with_memory(self, memory: Memory, before: _Played) -> None:
        """Begin with the values of equal observations, after those of the stage before are in the memory."""
        stage = self._stage
        self._kept = np.empty((len(self._codes), stage.values))
        remember(memory, before._codes, before._rows, before._kept, stage.width)
        initial_q = stage.tables.rules.initial_q
        recall(memory, self._codes, self._rows, initial_q, stage.width, self._kept, self._carried)

    def begin_with_ancestors(self, before: _Played) -> None:
        """Begin with the values of the states that the carry rule gives."""
        stage = self._stage
        self._kept = np.empty((len(self._codes), stage.values))
        for batch in self._batches:
            scenes = before._scene(batch), self._scene(batch)
            rule = same_place if isinstance(stage.carry, str) else stage.carry
            found = ancestors(rule, *scenes) if batch.stop else self._codes
            inherit(
                found, batch.start, before._rows, before._kept, self._rows, stage.tables.rules.initial_q,
                stage.width, self._kept, self._carried,
            )  # fmt: skip

    def learn(self) -> None:
        """Learn the stage in all periods of the share."""
        stage, share, tables = self._stage, self._share, self._stage.tables
        tabulated = not stage.point.msa.repeats
        paid = earnings(stage.point, tables, self._layouts[:, 1:])
        lanes = side_by_side(max(1, len(self._kept)), 1, (12 if tabulated else 8) * stage.values)
        running = empty_lanes(
            lanes,
            stage.states,
            tables.limits,
            tabulated=tabulated,
            drawn=tables.chance is not None,
            earnings=width_of(paid),
            kept=self._kept,
            states=self._generator,
        )
        # Read-only, as in other points: the kernel would be compiled again for another type.
        generator = self._generator.view()
        generator.setflags(write=False)
        learn(
            tables.next_cell, tables.limits, tables.threshold, tables.rules, self._codes, 0, self._layouts, generator,
            running, True, stage.steps[share], stage.success[share], stage.rows[share], self._table(),
            self._errors if stage.collects else None, tables.chance, paid, tables.method,
        )  # fmt: skip

    def _table(self) -> ActionTable | None:
        """Return what the actions do, if they follow a table."""
        stage, goals = self._stage, self._layouts[:, 1:]
        if stage.point.msa.repeats:
            return None
        if not len(goals):
            return no_table(stage.states, len(stage.tables.limits))
        return action_table(stage.point, goals, observation_codes(stage.point, goals))

    def _scene(self, batch: slice) -> StageScene:
        return StageScene(self._stage.point.world, self._layouts[batch, 1:], self._codes[batch])


def _most_observations(stages: Sequence[StagePoint]) -> int:
    """Return an upper bound of the number of observations that a period meets in all stages together."""
    points = [stage.point for stage in stages]
    goals: int = points[0].task.goals
    states: int = sum(goals * cell_count(point.world) for point in points)
    if not all(isinstance(point.representation, SizedRepresentation) for point in points):
        return states
    kinds = {(point.representation, point.world) for point in points}
    spanned: int = sum(representation.spanned_size(world, goals) for representation, world in kinds)
    return min(states, spanned)


def _shares(first: int, periods: int, threads: int, most: int) -> list[slice]:
    """Split the periods from the first one on into shares of about equal size, two for each of several threads."""
    left = periods - first
    count = min(left, max(-(-left // most), 2 * threads if threads > 1 else 1))
    ends = np.linspace(first, periods, count + 1).astype(int).tolist()
    return [slice(*pair) for pair in pairwise(ends)]


def _batches(periods: int, states: int) -> Iterator[slice]:
    """Yield the periods whose observation codes are computed at a time; none at all, if there are none, once."""
    size = max(1, _CODES_IN_FLIGHT // states)
    for first in range(0, max(1, periods), size):
        yield slice(first, min(first + size, periods))
