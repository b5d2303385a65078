"""From a design point to what it asks of the sequential kernel."""

from __future__ import annotations

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.design import (
    ClosedLoop,
    DesignPoint,
    DoubleQ,
    DynaQ,
    ExpectedSarsa,
    Exploration,
    NStep,
    OwnLearner,
    QLambda,
    Sarsa,
    TabularLearner,
    learned_in_lanes,
    level_of,
)
from rl_design_space.design.identity import full_name
from rl_design_space.learning.sequential.method import (
    ACCUMULATING,
    DOUBLE,
    EPSILON_GREEDY,
    EXPECTED,
    GREATEST,
    NEXT,
    OWN,
    PLANNING,
    REPLACING,
    SOFTMAX,
    STEPS,
    TREE,
    UPPER_BOUND,
    Behaviour,
    Learner,
    Method,
    StepSizes,
    no_notes,
)
from rl_design_space.learning.sequential.own import compiled_rule, compiled_update

_KINDS = {"epsilon": EPSILON_GREEDY, "temperature": SOFTMAX, "bonus": UPPER_BOUND}


def method_of(point: DesignPoint, levels: FloatArray) -> Method | None:
    """Return the method of a point; None if the kernel learns it in lanes.

    Args:
        point: the design point.
        levels: (trials,) the exploration schedule, whatever its levels are.
    """
    learner = point.learner
    if learned_in_lanes(point):
        return None
    behaviour = _behaviour(point.exploration, levels)
    return Method(_learner(learner), behaviour, StepSizes(learner.alphas(len(levels)), learner.visit_power), no_notes())


def _behaviour(exploration: Exploration, levels: FloatArray) -> Behaviour:
    """Return how actions are chosen."""
    rule, parameters = 0, np.empty(0)
    if isinstance(exploration, ClosedLoop):
        name = full_name(type(exploration))
        rule = compiled_rule(type(exploration).rule, name).address
        parameters = np.array(exploration.parameters, dtype=np.float64)
    return Behaviour(_KINDS[level_of(exploration)], levels, rule, parameters)


def _learner(learner: TabularLearner) -> Learner:
    """Return what is learned from a step."""
    nothing = Learner(GREATEST, chooses_first=False, number=0, trace_decay=0.0, update=0, parameters=np.empty(0))
    if isinstance(learner, Sarsa):
        return nothing._replace(kind=NEXT, chooses_first=True)
    if isinstance(learner, ExpectedSarsa):
        return nothing._replace(kind=EXPECTED)
    if isinstance(learner, DoubleQ):
        return nothing._replace(kind=DOUBLE)
    if isinstance(learner, NStep):
        tree = learner.backup == "tree"
        return nothing._replace(kind=TREE if tree else STEPS, chooses_first=not tree, number=learner.n)
    if isinstance(learner, QLambda):
        kind = ACCUMULATING if learner.traces == "accumulating" else REPLACING
        return nothing._replace(kind=kind, trace_decay=learner.trace_decay)
    if isinstance(learner, DynaQ):
        return nothing._replace(kind=PLANNING, number=learner.planning)
    if isinstance(learner, OwnLearner):
        update = compiled_update(type(learner).update, full_name(type(learner)))
        return nothing._replace(
            kind=OWN,
            chooses_first=learner.chooses_first,
            update=update.address,
            parameters=np.array(learner.parameters, dtype=np.float64),
        )
    return nothing
