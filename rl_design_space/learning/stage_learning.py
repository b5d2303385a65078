"""A stage as it is learned: what all periods share, and what those of a share have."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, StagePoint, cell_count
from rl_design_space.learning.carrying import Memory, carry_over, inherit, number_rows, same_place
from rl_design_space.learning.checked import action_table, ancestors, observation_codes, portable_codes
from rl_design_space.learning.controls import ActionTable, no_table
from rl_design_space.learning.earning import earnings, width_of
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import empty_lanes, row_width, side_by_side
from rl_design_space.learning.optimum import optimal_steps
from rl_design_space.learning.refining import refine_into
from rl_design_space.learning.stage_layouts import StageScene
from rl_design_space.learning.stage_record import StageRecord
from rl_design_space.learning.tables import learning_tables
from rl_design_space.learning.td_errors import Errors, no_errors

#: Observation codes computed at a time: more than in `simulation`, because those of all periods are kept anyway.
_CODES_IN_FLIGHT = 120_000


class StageOfPoint:
    """A stage of a point: its tables, and what all threads write of it.

    Args:
        stage: the stage.
        layouts: (periods, 1 + n_goals) start and goals.
        following: the next stage; None of the last one.
    """

    def __init__(self, stage: StagePoint, layouts: NDArray[np.int32], following: StagePoint | None) -> None:
        point: DesignPoint = stage.point
        self.point, self.carry, self.refine, self.layouts = point, stage.carry, stage.refine, layouts
        #: Whether the next stage asks for the Q-matrices of this one, and for its TD errors.
        self.is_carried = bool(following and following.carry != "none")
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


class StageOfShare:
    """A stage of a share of the periods.

    Args:
        stage: the stage.
        share: the periods.
        generator: (taken, 4) uint64, states of their random generators, modified in place.
        before: the stage before, if any.
    """

    def __init__(
        self, stage: StageOfPoint, share: slice, generator: NDArray[np.uint64], before: StageOfShare | None
    ) -> None:
        self._stage, self._share, taken = stage, share, len(generator)
        self._layouts, self._generator = stage.layouts[share], generator
        self._batches = list(_batches(taken, stage.states))
        #: Observation codes, (taken, n_goals, cells) int64.
        self._codes = np.empty((taken, stage.point.task.goals, cell_count(stage.point.world)), dtype=np.int64)
        if stage.refine and before:
            refine_into(self._codes, before._rows, stage.point.world.shape[0], stage.refine, before._errors)
        else:
            for batch in self._batches:
                self._codes[batch] = portable_codes(stage.point, self._layouts[batch, 1:])
        self._errors: Errors = no_errors(taken if stage.collects else 0, stage.states, len(stage.tables.limits))
        self._carried = stage.carried[share]
        #: Q-matrices that periods begin with, (taken, values), or none; and those that they end with, if needed.
        self._given: FloatArray = np.empty((0, 0))
        self._kept: FloatArray = np.empty((0, 0))

    @cached_property
    def _rows(self) -> NDArray[np.int64]:
        """Rows of the Q-matrices by state, (taken, n_goals, cells) int64; of one period if they are those of all."""
        rows = np.empty_like(self._codes)
        return rows[: number_rows(self._codes, rows)]

    def observes_the_same_as(self, before: StageOfShare) -> bool:
        """Return whether all observations are those of another stage, state by state."""
        return len(self._codes) > 0 and np.array_equal(self._codes, before._codes)

    def begin_anew(self) -> None:
        """Begin with initial values."""
        if self._stage.is_carried:
            self._kept = self._no_values()

    def begin_where_ended(self, before: StageOfShare) -> None:
        """Begin with the Q-matrices that a stage of equal observations has ended with."""
        self._begin_with(before._kept)
        self._carried[:] = before._stage.rows[self._share, 0]

    def begin_with_memory(self, memory: Memory, before: StageOfShare, *, anew: bool) -> None:
        """Begin with the values of equal observations, after those of the stage before are in the memory."""
        stage, given = self._stage, self._no_values()
        carry_over(
            memory, anew, before._codes, before._rows, before._kept, self._codes, self._rows,
            stage.tables.rules.initial_q, stage.width, given, self._carried,
        )  # fmt: skip
        self._begin_with(given)

    def begin_with_ancestors(self, before: StageOfShare) -> None:
        """Begin with the values of the states that the carry rule gives."""
        stage, given = self._stage, self._no_values()
        for periods, found in self._ancestors(before):
            inherit(
                found, periods.start, periods.stop - periods.start, before._rows, before._kept, self._rows,
                stage.tables.rules.initial_q, stage.width, given, self._carried,
            )  # fmt: skip
        self._begin_with(given)

    def _no_values(self) -> FloatArray:
        return np.empty((len(self._codes), self._stage.values))

    def _begin_with(self, values: FloatArray) -> None:
        """Begin with Q-matrices; those that the periods end with are written over them, if they are needed."""
        self._given = values
        if self._stage.is_carried:
            self._kept = values

    def _ancestors(self, before: StageOfShare) -> Iterator[tuple[slice, NDArray[np.int64]]]:
        """Yield the ancestors of the states in some of the periods after the other, see `inherit`."""
        point, carry = self._stage.point, self._stage.carry
        if isinstance(carry, str) or not len(self._codes):
            yield slice(0, len(self._codes)), same_place(before._stage.point.world, point.world, point.task.goals)
            return
        for batch in self._batches:
            yield batch, ancestors(carry, before._scene(batch), self._scene(batch))

    def learn(self) -> None:
        """Learn the stage in all periods of the share."""
        stage, share, tables = self._stage, self._share, self._stage.tables
        tabulated = not stage.point.msa.repeats
        paid = earnings(stage.point, tables, self._layouts[:, 1:])
        lanes = side_by_side(max(1, len(self._codes)), 1, (12 if tabulated else 8) * stage.values)
        running = empty_lanes(
            lanes,
            stage.states,
            tables.limits,
            tabulated=tabulated,
            drawn=tables.chance is not None,
            earnings=width_of(paid),
            given=self._given,
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


def _batches(periods: int, states: int) -> Iterator[slice]:
    """Yield the periods whose observation codes are computed at a time."""
    size = max(1, _CODES_IN_FLIGHT // states)
    for first in range(0, periods, size):
        yield slice(first, min(first + size, periods))
