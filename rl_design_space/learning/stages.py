"""Learning periods of several stages, which share a Q-matrix and a random stream (docs/decisions/0030-stages.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, SizedRepresentation, StagePoint, cell_count
from rl_design_space.learning.carrying import Memory, empty_memory
from rl_design_space.learning.joint import JointLearning
from rl_design_space.learning.memory import check_memory
from rl_design_space.learning.result import LearningCurves
from rl_design_space.learning.sequential.own import refuse_broken
from rl_design_space.learning.stage_layouts import stage_layouts
from rl_design_space.learning.stage_learning import StageOfPoint, StageOfShare
from rl_design_space.learning.stage_record import bounds
from rl_design_space.learning.streams import behaviour_states

#: Bytes of the Q-matrices of the periods that a thread takes through all stages at a time.
_SHARE_BYTES = 2**27


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
        self._stages = [
            StageOfPoint(*each) for each in zip(stages, stage_layouts(point, stages), following, strict=True)
        ]
        self._generator = behaviour_states(point.seed, point.task.periods)
        self._met = _most_observations(stages)
        # Without periods: this compiles, or loads compiled code, outside the measured time.
        self._learn(slice(0, 0))
        values = self._met * self._stages[0].width + 3 * max(stage.values for stage in self._stages)
        first = self._copy(begun) if begun else 0
        size = _share_size(point.task.periods - first, threads, most=max(1, _SHARE_BYTES // (8 * values)))
        self.begin(first, lambda left, least: size)

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
        before: StageOfShare | None = None
        for stage, following in zip_longest(self._stages, self._stages[1:]):
            now = StageOfShare(stage, share, generator, before)
            if before is None or stage.carry == "none":
                now.begin_anew()
            elif stage.carry != "same_observation":
                now.begin_with_ancestors(before)
            elif now.observes_the_same_as(before):
                now.begin_where_ended(before)
            else:
                anew = memory is None and (following is None or following.carry != "same_observation")
                memory = memory or empty_memory(1 if anew else len(generator), self._met, stage.width)
                now.begin_with_memory(memory, before, anew=anew)
            memory = memory if stage.carry == "same_observation" else None
            now.learn()
            if self.is_stopped:
                return
            before = now


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


def _share_size(left: int, threads: int, most: int) -> int:
    """Return the size of shares, all of about the same size, two for each of several threads."""
    count = max(-(-left // most), 2 * threads if threads > 1 else 1)
    return -(-left // count)
