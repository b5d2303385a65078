"""How much work a design point is likely to be."""

from __future__ import annotations

from collections.abc import Iterable

from rl_design_space.design import DesignPoint, cell_count

#: Moves until a goal is found for the first times and the way to it is learned: first · cells^growth. Moves of a trial
#: later on: over · the mean distance of two cells. Fitted to Table 4; other choices change it by a factor of two or so.
_FIRST, _GROWTH, _OVER = 2.0, 1.47, 1.5


def expected_moves(point: DesignPoint) -> float:
    """Primitive moves that learning a point will roughly take, over all trials and periods.

    Good enough to begin with the longest points and to foresee when a sweep ends; not for science.
    """
    task, cells = point.task, cell_count(point.world)
    distance = sum(point.world.shape) / 4
    period: float = task.goals * (_FIRST * cells**_GROWTH + _OVER * distance * task.trials)
    return task.periods * min(period, task.trials * task.max_steps)


#: Seconds: of a move (docs/performance.md), of what a point is beside its moves, of its record, of a start.
_MOVE, _POINT, _RECORD, _START = 7e-9, 0.005, 0.1, 3.0


def expected_seconds(points: Iterable[DesignPoint], threads: int) -> float:
    """Roughly how long learning and recording these points takes, with this many threads and one recorder."""
    moves = [expected_moves(point) for point in points]
    if not moves:
        return 0.0
    learning, recording = sum(moves) * _MOVE + len(moves) * _POINT, len(moves) * _RECORD
    return _START + max((learning + recording) / threads, recording, max(moves) * _MOVE / threads)
