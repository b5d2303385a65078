"""The forms of the kernel that many tests use, compiled before them.

The kernel is compiled for what a point needs: its number of actions, a table of them, chance, rewards by transition,
errors, another learner. A form takes a process 5 to 15 s, and half of that if the process has compiled a similar one,
because they share functions. So each process that runs tests compiles forms that are similar to each other, and none
that another process compiles; commands find them on disk.
"""

from __future__ import annotations

from dataclasses import replace

from rl_design_space.design import (
    Aggregated,
    Controllers,
    DesignPoint,
    Direction,
    MultiStepActions,
    Refine,
    Sarsa,
    ShapedReward,
    Slip,
    Task,
    Torus,
)
from rl_design_space.learning import simulate

_PLAIN = DesignPoint(task=Task(goals=1, trials=2, periods=1, max_steps=20), world=Torus(size=4))
_BY_CHANCE = replace(_PLAIN, world=Slip(size=4, p=0.3))
_TO_LENGTH = MultiStepActions(lengths=(3,))
_TO_CHANGE = MultiStepActions(lengths=(3,), until="observation_changes")

#: Points of similar forms, and whether their paths are replayed, which another function learns. Parts take about as
#: long as each other, because tests begin when all are compiled.
SIMILAR: tuple[tuple[tuple[DesignPoint, bool], ...], ...] = (
    (
        (_PLAIN, True),
        (replace(_PLAIN, reward=ShapedReward()), False),
        (_BY_CHANCE, False),
        (replace(_BY_CHANCE, reward=ShapedReward()), False),
        (replace(_PLAIN, learner=Sarsa()), False),
        (replace(_BY_CHANCE, learner=Sarsa(), reward=ShapedReward()), False),
        (replace(_PLAIN, representation=Aggregated(block=2), curriculum=Refine()), False),
    ),
    (
        (replace(_PLAIN, msa=_TO_LENGTH), True),
        (replace(_PLAIN, msa=MultiStepActions(lengths=(2, 3))), False),
        (replace(_BY_CHANCE, msa=_TO_LENGTH, reward=ShapedReward()), True),
        (replace(_PLAIN, msa=_TO_CHANGE), False),
        (replace(_BY_CHANCE, msa=_TO_CHANGE, reward=ShapedReward()), False),
        (replace(_PLAIN, msa=Controllers(), representation=Direction()), True),
    ),
)


def compile_forms(process: int, processes: int) -> None:
    """Compile the part of a process, or load what is compiled already.

    Args:
        process: number of this process, from 0.
        processes: how many there are.
    """
    for similar in SIMILAR[process::processes]:
        for point, is_replayed in similar:
            simulate(point, threads=1, keep=["paths"] if is_replayed else ())
