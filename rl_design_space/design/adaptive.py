"""Behaviours beyond a schedule of ε: softmax, visit bonuses, optimism, and ε that follows how the period goes."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT

_Probability = Annotated[float, Field(ge=0, le=1)]

#: The highest temperature.
_HOTTEST = 1e6

#: What the schedule of an exploration gives: ε, the temperature of softmax, or the weight of a visit bonus.
Level = Literal["epsilon", "temperature", "bonus"]


def level_of(exploration: Any) -> Level:
    """Return what the schedule of an exploration gives; ε unless its class says otherwise by a class attribute `level`.

    A field of this name is the component's own.
    """
    is_field = is_dataclass(exploration) and any(field.name == "level" for field in fields(exploration))
    level: Level = "epsilon" if is_field else getattr(exploration, "level", "epsilon")
    return level


class Counters(NamedTuple):
    """How a period has gone so far, when a trial begins.

    Attributes:
        trial: number of the trial, τ ≥ 1.
        level: ε of the trial before.
        successes: number of successes so far.
        succeeded: 1 if the trial before was a success, otherwise 0.
        steps: its number of steps.
        error: mean size of its errors, the differences that α multiplies.
    """

    trial: float
    level: float
    successes: float
    succeeded: float
    steps: float
    error: float


@runtime_checkable
class ClosedLoop(Protocol):
    """An exploration whose ε follows how the period goes; `schedule` gives that of the first trial."""

    @property
    def parameters(self) -> tuple[float, ...]:
        """Numbers that the rule uses."""
        ...

    @staticmethod
    def rule(counters: Counters, parameters: Any) -> float:
        """Return ε of the trial that begins. It is compiled, so it may use numbers alone."""
        ...


@runtime_checkable
class OptimisticValues(Protocol):
    """An exploration that says what Q-values begin with."""

    def initial_q(self, rewards: FloatArray, goals: int) -> float:
        """Return the initial Q-value, from the rewards of a step, a sub-goal and the final goal."""
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Softmax:
    """Actions in proportion to e^(Q/T), the temperature T = max(temperature·fall^(-τ), lowest).

    Sutton and Barto, 2.8 (there of preferences).

    Attributes:
        temperature: T of the first trial: a difference of T between two values makes one e times as likely.
        fall: factor by which T falls per trial; 1 keeps it, below 1 it grows, up to 10⁶.
        lowest: the lowest T.
    """

    level: ClassVar[Level] = "temperature"

    temperature: Annotated[float, Field(ge=1e-6, le=1e6)] = 1.0
    fall: Annotated[float, Field(gt=0)] = 1.05
    lowest: Annotated[float, Field(ge=1e-6, le=1e6)] = 0.01

    def schedule(self, trials: int) -> FloatArray:
        with np.errstate(under="ignore", over="ignore"):
            fallen = self.temperature * self.fall ** -np.arange(trials, dtype=np.float64)
            return np.clip(fallen, self.lowest, _HOTTEST)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class UpperConfidenceBound:
    """The action with the greatest Q(s,a) + weight·√(ln t / N(s,a)) (Sutton and Barto, 2.7, for each observation).

    N counts how often the action was chosen at this observation in the period (in each stage anew), t all actions
    there. An action that was never chosen comes first.

    Attributes:
        weight: weight of the bonus; with 0, every action is tried once and then the best one taken.
    """

    level: ClassVar[Level] = "bonus"

    weight: Annotated[float, Field(ge=0, le=1e6)] = 0.5

    def schedule(self, trials: int) -> FloatArray:
        return np.full(trials, self.weight)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Optimistic:
    """Q-values begin as scale · (the rewards of all goals together), so that what was not tried looks best.

    With scale 1 that is an upper bound of every return (if steps cost something), and unlike a number for
    `learner.initial_q` it follows the reward function and the number of goals. Sutton and Barto, 2.6.

    Attributes:
        scale: share of the bound.
        epsilon: probability of an exploratory action, in every trial.
    """

    scale: Annotated[float, Field(ge=0, le=100)] = 1.0
    epsilon: _Probability = 0.0

    def schedule(self, trials: int) -> FloatArray:
        return np.full(trials, self.epsilon)

    def initial_q(self, rewards: FloatArray, goals: int) -> float:
        _, sub_goal, final_goal = rewards.tolist()
        bound: float = self.scale * ((goals - 1) * sub_goal + final_goal)
        return bound


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _ClosedLoop:
    """Base of the closed loops.

    Attributes:
        start: ε of the first trial.
        lowest: the lowest ε.
    """

    start: _Probability = 0.9
    lowest: _Probability = 0.0

    @model_validator(mode="after")
    def _lowest_is_low(self) -> _ClosedLoop:
        if self.lowest > self.start:
            raise ValueError(f"exploration.lowest={self.lowest}: should be at most exploration.start={self.start}")
        return self

    def schedule(self, trials: int) -> FloatArray:
        return np.full(trials, self.start)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class SuccessDriven(_ClosedLoop):
    """ε falls by a factor after each success of the period.

    Attributes:
        factor: what ε is multiplied by after a success.
    """

    factor: _Probability = 0.9

    @property
    def parameters(self) -> tuple[float, ...]:
        return self.factor, self.lowest

    @staticmethod
    def rule(counters: Counters, parameters: Any) -> float:
        factor, lowest = parameters[0], parameters[1]
        epsilon: float = max(counters.level * factor, lowest) if counters.succeeded > 0 else counters.level
        return epsilon


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ErrorDriven(_ClosedLoop):
    """ε = lowest + (start - lowest)·d/(d + half), where d is the mean size of the errors of the trial before.

    Explore while values still change, as Tokic (2010) does for each state.

    Attributes:
        half: the mean error at which ε is half-way.
    """

    half: Annotated[float, Field(gt=0, le=1e6)] = 0.1

    @property
    def parameters(self) -> tuple[float, ...]:
        return self.start, self.lowest, self.half

    @staticmethod
    def rule(counters: Counters, parameters: Any) -> float:
        start, lowest, half = parameters[0], parameters[1], parameters[2]
        epsilon: float = lowest + (start - lowest) * (counters.error / (counters.error + half))
        return epsilon
