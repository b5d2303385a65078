"""Learners and behaviours that mean nothing with other choices, or whose own functions break, are refused by name."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest

from rl_design_space.design import (
    Aggregated,
    DesignPoint,
    MultiStepActions,
    Optimistic,
    OwnLearner,
    QLearning,
    Refine,
    Sarsa,
    Softmax,
    Task,
    Torus,
)
from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate

SMALL = DesignPoint(task=Task(goals=2, trials=6, periods=2, max_steps=150), world=Torus(size=4))


def refusals() -> Iterator[tuple[dict[str, object], str]]:
    msa = MultiStepActions(lengths=(3,))
    yield {"learner": Sarsa(), "msa": msa}, "learner=Sarsa: goes with msa=none alone"
    yield (
        {"learner": QLearning(alpha_schedule="visits"), "msa": msa},
        "learner.alpha_schedule=visits: goes with msa=none",
    )
    yield {"exploration": Softmax(), "msa": msa}, "exploration=Softmax: goes with msa=none alone"
    yield {"exploration": Softmax(), "learner": Sarsa(explore="all")}, "learner.explore=all: says what ε-greedy"
    yield (
        {"exploration": Optimistic(), "learner": Sarsa(initial_q=1.0)},
        "learner.initial_q=1.0: exploration=Optimistic",
    )
    blocks = {"representation": Aggregated(), "curriculum": Refine(split="disagreeing")}
    yield {"learner": Sarsa(), **blocks}, "refine=disagreeing: TD errors are those of Q-learning with constant α"


@pytest.mark.parametrize(
    ("choices", "message"), list(refusals()), ids=lambda value: value if isinstance(value, str) else ""
)
def test_what_means_nothing_is_refused_by_name(choices: dict[str, object], message: str):
    with pytest.raises(ValueError, match=message):
        DesignPoint(**choices)


def test_values_of_another_schedule_are_refused():
    with pytest.raises(ValueError, match=r"learner.alpha_fall=0.1: belongs to .*=linear, not visits"):
        Sarsa(alpha_schedule="visits", alpha_fall=0.1)


class Unfit(OwnLearner):
    """A learner that cannot be compiled."""

    @staticmethod
    def update(step, q, memory, parameters):
        return {"no": object()}[step]


def test_an_update_that_cannot_be_compiled_is_refused():
    with pytest.raises(ConfigError, match=r"learner: .*Unfit.update\(\): cannot be compiled by Numba: "):
        simulate(replace(SMALL, learner=Unfit()))


@dataclass(frozen=True, kw_only=True)
class Broken(OwnLearner):
    """Writes beyond the Q-matrix, or returns no number."""

    beyond: int = 0

    @property
    def parameters(self):
        return (float(self.beyond),)

    @staticmethod
    def update(step, q, memory, parameters):
        q[step.row + int(parameters[0]), step.action] += 1.0
        return math.nan


@dataclass(frozen=True, kw_only=True)
class Loud:
    """A rule that gives no probability."""

    epsilon: float = 5.0

    def schedule(self, trials):
        return np.ones(trials)

    @property
    def parameters(self):
        return (self.epsilon,)

    @staticmethod
    def rule(counters, parameters):
        return parameters[0]


@pytest.mark.parametrize("beyond", [0, 10**8])
def test_an_own_update_that_breaks_fails_its_point_alone(beyond: int):
    with pytest.raises(ConfigError, match=r"Broken\.update\(\): gave an error .*, in period 0"):
        simulate(replace(SMALL, learner=Broken(beyond=beyond)), threads=1)


@pytest.mark.parametrize("epsilon", [5.0, math.nan])
def test_an_own_rule_that_gives_no_probability_is_refused(epsilon: float):
    with pytest.raises(ConfigError, match=r"Loud\.rule\(\): should give ε, a number from 0 to 1, in period 0"):
        simulate(replace(SMALL, exploration=Loud(epsilon=epsilon)), threads=1)
