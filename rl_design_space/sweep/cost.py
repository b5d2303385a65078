"""How much work a design point is likely to be."""

from __future__ import annotations

from rl_design_space.design import DesignPoint, cell_count

#: Moves until a goal is found for the first times and the way to it is learned: first · cells^growth. Moves of a trial
#: later on: over · the mean distance of two cells. Fitted to Table 4; other choices change it by factors of two or three.
_FIRST, _GROWTH, _OVER = 2.0, 1.47, 1.5


def expected_moves(point: DesignPoint) -> float:
    """Primitive moves that learning a point will roughly take, over all trials and periods.

    Good enough to begin with the longest points and to foresee when a sweep ends; not for science.
    """
    task, cells = point.task, cell_count(point.world)
    distance = sum(point.world.shape) / 4
    period: float = task.goals * (_FIRST * cells**_GROWTH + _OVER * distance * task.trials)
    return task.periods * min(period, task.trials * task.max_steps)
