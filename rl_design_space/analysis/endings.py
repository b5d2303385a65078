"""How failed trials end: in a circle or not, within one observation or several."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from rl_design_space.learning.memoryless import Memoryless
    from rl_design_space.learning.replay import Replay

#: Last steps of a trial that its end is judged by, at most.
LAST = 1000
#: Kinds of endings: whether the agent passes the same states again and again, and whether it has one observation only.
CIRCLE_IN_ONE, CIRCLE = "circle in one observation", "circle through several"
WANDERING_IN_ONE, WANDERING = "no circle, one observation", "no circle, several"
ENDINGS = (CIRCLE_IN_ONE, CIRCLE, WANDERING_IN_ONE, WANDERING)
#: Verdicts on a period with a failed trial.
NOT_LEARNED, NOT_REPRESENTED, OPEN = "not learned", "cannot be represented", "open"


@dataclass(frozen=True)
class Ending:
    """The last steps of a trial.

    Attributes:
        kind: one of `ENDINGS`.
        reached: number of goals reached.
        circle: steps after which the agent is in the same states again, and again until the end; 0 if it is not.
        observations: number of different observations.
        row: the most frequent of them.
        share: its share of the steps.
        stays: share of steps after which the observation is the same as before.
    """

    kind: str
    reached: int
    circle: int
    observations: int
    row: int
    share: float
    stays: float


def ending(inside: Replay, trial: int, last: int = LAST) -> Ending:
    """Return how a trial ends that does not reach the final goal.

    A circle is exact: the states of the last steps repeat, and are passed at least twice.

    Args:
        inside: a period with its paths.
        trial: number of the trial.
        last: number of steps that are looked at, at most.
    """
    assert inside.paths is not None
    path = inside.paths[trial]
    counters, cells = path.counters[-last - 1 :], path.cells[-last - 1 :]
    states = counters.astype(np.int64) * inside.row.shape[1] + cells
    rows = inside.row.ravel()[states]
    again = np.flatnonzero(states[:-1] == states[-1])
    lengths = (len(states) - 1 - again)[::-1]
    circle = next((n for n in lengths.tolist() if 2 * n < len(states) and (states[n:] == states[:-n]).all()), 0)
    numbers, counts = np.unique(rows, return_counts=True)
    in_one = len(numbers) == 1
    kind = (CIRCLE_IN_ONE if in_one else CIRCLE) if circle else (WANDERING_IN_ONE if in_one else WANDERING)
    return Ending(
        kind=kind,
        reached=int(counters[-1]),
        circle=circle,
        observations=len(numbers),
        row=int(numbers[counts.argmax()]),
        share=float(counts.max() / len(rows)),
        stays=float((rows[1:] == rows[:-1]).mean()),
    )


def verdict(best: Memoryless) -> str:
    """Return why trials of a period fail, as far as the best memoryless policy of its layout tells.

    A policy that reaches the final goal was not learned; if it is proven that there is none, the representation cannot
    express one; if none was found, it is open.
    """
    if best.steps is not None:
        return NOT_LEARNED
    return OPEN if best.is_possible else NOT_REPRESENTED
