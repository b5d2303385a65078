"""What a step costs with each learner and exploration, beside one of Q-learning in lanes."""

from __future__ import annotations

from typing import Any

from rl_design_space.design import (
    DesignPoint,
    DoubleQ,
    DynaQ,
    ExpectedSarsa,
    NStep,
    QLambda,
    learned_in_lanes,
    level_of,
)

#: Nanoseconds of a step of Q-learning in lanes, and of one that is learned period by period (docs/performance.md).
_IN_LANES, _ALONE = 7.0, 22.0
#: Nanoseconds more: by exploration, by α that falls with visits, and those of roots of their number.
_CHOOSING = {"temperature": 75.0, "bonus": 45.0}
_VISITS, _ROOTS = 8.0, 53.0
#: Share of the steps of Q-learning that learners need that learn more from a step.
_FEWER = 0.75


def relative_cost(point: DesignPoint) -> float:
    """Return what a period costs with the learner and exploration of a point, in costs of one of Q-learning.

    It counts that some learners need fewer steps. Measured with a schedule of ε, where it is right within a factor of
    1.5 for all shipped learners; how many steps another exploration needs is not known beforehand.
    """
    if learned_in_lanes(point):
        return 1.0
    learner = point.learner
    cost = _ALONE + _more(learner) + _CHOOSING.get(level_of(point.exploration), 0.0)
    if learner.alpha_schedule == "visits":
        cost += _VISITS
    elif learner.alpha_schedule == "polynomial":
        cost += _ROOTS
    return cost / _IN_LANES * (_FEWER if _learns_more(learner) else 1.0)


def _more(learner: Any) -> float:
    """Return the nanoseconds of a step beyond those of Sarsa."""
    if isinstance(learner, ExpectedSarsa):
        return 10.0
    if isinstance(learner, DoubleQ):
        return 4.0
    if isinstance(learner, QLambda):
        return 15.0
    if isinstance(learner, NStep):
        return 20.0 * learner.n - 5.0 if learner.backup == "tree" else 3.0 + 1.8 * learner.n
    return 17.5 * learner.planning if isinstance(learner, DynaQ) else 0.0


def _learns_more(learner: Any) -> bool:
    """Return whether a learner passes a reward on to several steps before, plans, or begins with a large α."""
    return (
        isinstance(learner, QLambda)
        or (isinstance(learner, NStep) and learner.n > 1)
        or (isinstance(learner, DynaQ) and learner.planning > 0)
        or learner.alpha_schedule in ("visits", "polynomial")
    )
