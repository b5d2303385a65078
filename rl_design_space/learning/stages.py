"""Learning periods of several stages, which share one Q-matrix and one random stream (docs/decisions/0030-stages.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import DesignPoint, SizedRepresentation, StagePoint, cell_count
from rl_design_space.learning.carrying import (
    Memory,
    StageScene,
    empty_memory,
    inherit,
    recall,
    remember,
    same_place,
)
from rl_design_space.learning.checked import ancestors, portable_codes
from rl_design_space.learning.joint import JointLearning
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import empty_lanes, side_by_side
from rl_design_space.learning.memory import check_memory
from rl_design_space.learning.optimum import shortest_tours
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.stage_layouts import stage_layouts
from rl_design_space.learning.stage_record import StageRecord
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import learning_tables

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

    Raises:
        ConfigError: an option returns a table that violates its contract, a goal cannot be reached, or the results
            need more memory than there is.
    """

    def __init__(self, point: DesignPoint, stages: Sequence[StagePoint], threads: int = 1) -> None:
        super().__init__()
        check_memory(replace(point.task, trials=sum(stage.point.task.trials for stage in stages)))
        self._point = point
        self._stages = [_Stage(*each) for each in zip(stages, stage_layouts(point, stages), strict=True)]
        self._generator = behaviour_states(point.seed, point.task.periods)
        self._met = _most_observations(stages)
        # Without periods: this compiles, or loads compiled code, outside the measured time.
        self._learn(slice(0, 0))
        values = self._met * self._stages[0].n_actions + 2 * max(stage.values for stage in self._stages)
        self.begin(_shares(point.task.periods, threads, most=max(1, _SHARE_BYTES // (8 * values))))

    def curves(self) -> LearningCurves:
        """Return the result, after the learning is complete; its optimum and rows are those of the last stage.

        Raises:
            Exception: the error that stopped the learning.
        """
        seconds, last = self.seconds(), self._stages[-1]
        return LearningCurves(
            steps=np.concatenate([stage.steps for stage in self._stages], axis=1),
            success=np.concatenate([stage.success for stage in self._stages], axis=1),
            optimum=last.optimum,
            rows=last.rows,
            epsilon=np.concatenate([stage.tables.epsilon for stage in self._stages]),
            seconds=seconds,
            known_point=self._point,
            stages=tuple(stage.record() for stage in self._stages),
        )

    def _work(self) -> None:
        while (share := self.next_share()) is not None:
            self._learn(share)

    def _learn(self, share: slice) -> None:
        """Learn all stages of a share of the periods."""
        generator = self._generator[share].copy()
        memory: Memory | None = None
        before: _Played | None = None
        for number, stage in enumerate(self._stages, 1):
            now = _Played(stage, share, generator)
            for batch in _batches(len(generator), stage.states):
                now.see(batch)
                now.begin_with(batch, before, memory if stage.carry == "same_observation" else None)
                now.learn(batch)
            now.learn(slice(0, 0), drain=True)
            if self.is_stopped:
                return
            if stage.carry != "same_observation":
                memory = None
            if number < len(self._stages) and self._stages[number].carry == "same_observation":
                memory = memory or empty_memory(len(generator), self._met, stage.n_actions)
                remember(memory, now.codes, now.kept, stage.n_actions)
            before = now


class _Stage:
    """A stage of a point: its tables, and what all threads write of it.

    Args:
        stage: the stage.
        layouts: (periods, 1 + n_goals) start and goals.
    """

    def __init__(self, stage: StagePoint, layouts: NDArray[np.int32]) -> None:
        point: DesignPoint = stage.point
        self.point, self.carry, self.layouts = point, stage.carry, layouts
        self.tables = learning_tables(point)
        self.optimum = shortest_tours(self.tables.next_cell, layouts)
        self.n_actions, self.states = 4 * len(self.tables.lengths), point.task.goals * cell_count(point.world)
        self.values = self.states * self.n_actions
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
    """

    def __init__(self, stage: _Stage, share: slice, generator: NDArray[np.uint64]) -> None:
        self._stage, self._share, taken = stage, share, len(generator)
        goals, cells = stage.point.task.goals, cell_count(stage.point.world)
        self.codes = np.empty((taken, goals, cells), dtype=np.int64)
        self.kept = np.empty((taken, stage.values))
        lanes = side_by_side(taken, 1, bytes_each=8 * stage.values)
        self._lanes = empty_lanes(lanes, stage.states, stage.tables.lengths, self.kept, generator)
        self._layouts = stage.layouts[share]
        #: Read-only, as in other points: the kernel would be compiled again for another type.
        self._generator = generator.view()
        self._generator.setflags(write=False)

    def see(self, batch: slice) -> None:
        """Compute the observation codes of some of the periods."""
        self.codes[batch] = portable_codes(self._stage.point, self._layouts[batch, 1:])

    def begin_with(self, batch: slice, before: _Played | None, memory: Memory | None) -> None:
        """Fill the Q-matrices that some of the periods begin with.

        Args:
            batch: those periods.
            before: the stage before; None in the first stage.
            memory: values of earlier stages, if they are carried by observation.
        """
        stage, codes, initial_q = self._stage, self.codes[batch], self._stage.point.learner.initial_q
        carried = stage.carried[self._share]
        if stage.carry == "none" or before is None:
            self.kept[batch] = initial_q
        elif memory is not None:
            recall(memory, batch.start, codes, initial_q, stage.n_actions, self.kept, carried)
        else:
            scenes = before._scene(batch), self._scene(batch)
            found = same_place(*scenes) if stage.carry == "same_place" else ancestors(stage.carry, *scenes)
            inherit(
                found, before.codes, before.kept, batch.start, codes, initial_q, stage.n_actions, self.kept, carried
            )

    def learn(self, batch: slice, *, drain: bool = False) -> None:
        """Learn some of the periods."""
        stage, share, tables = self._stage, self._share, self._stage.tables
        learn(
            tables.next_cell, tables.lengths, tables.threshold, tables.rules, self.codes[batch], batch.start,
            self._layouts, self._generator, self._lanes, drain, stage.steps[share], stage.success[share],
            stage.rows[share],
        )  # fmt: skip

    def _scene(self, batch: slice) -> StageScene:
        return StageScene(self._stage.point.world, self._layouts[batch, 1:], self.codes[batch])


def _most_observations(stages: Sequence[StagePoint]) -> int:
    """Return an upper bound of the number of observations that a period meets in all stages together."""
    points = [stage.point for stage in stages]
    goals = points[0].task.goals
    states = sum(goals * cell_count(point.world) for point in points)
    if not all(isinstance(point.representation, SizedRepresentation) for point in points):
        return states
    kinds = {(point.representation, point.world) for point in points}
    return min(states, sum(representation.spanned_size(world, goals) for representation, world in kinds))


def _shares(periods: int, threads: int, most: int) -> list[slice]:
    """Split the periods into shares of about equal size, two for each of several threads."""
    count = min(periods, max(-(-periods // most), 2 * threads if threads > 1 else 1))
    bounds = np.linspace(0, periods, count + 1).astype(int).tolist()
    return [slice(*pair) for pair in pairwise(bounds)]


def _batches(periods: int, states: int) -> Iterator[slice]:
    """Yield the periods whose observation codes are computed at a time."""
    size = max(1, _CODES_IN_FLIGHT // states)
    for first in range(0, periods, size):
        yield slice(first, min(first + size, periods))
