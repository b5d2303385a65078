"""Exploration schedules: the probability ε of an exploratory action, by trial (paper, section 3.2)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import FloatArray
from rl_design_space._strict import STRICT

_Probability = Annotated[float, Field(ge=0, le=1)]


@runtime_checkable
class Exploration(Protocol):
    """A schedule of ε over the trials of a period."""

    def schedule(self, trials: int) -> FloatArray:
        """Return the probability ε of an exploratory action in every trial, (trials,) float64."""
        ...


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Constant:
    """The same ε in every trial.

    Attributes:
        epsilon: probability of an exploratory action.
    """

    epsilon: _Probability = 0.1

    def schedule(self, trials: int) -> FloatArray:
        return np.full(trials, self.epsilon)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class _Decay:
    """Base of the decaying schedules.

    Attributes:
        first_trial: τ of the first trial. The paper counts from 0; 1 is the other reading.
    """

    first_trial: Annotated[int, Field(ge=0)] = 0

    def _tau(self, trials: int) -> FloatArray:
        return np.arange(self.first_trial, self.first_trial + trials, dtype=np.float64)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Linear(_Decay):
    """ε = max(start - k·τ, 0).

    Attributes:
        start: ε at τ = 0.
        k: decrease of ε per trial; the paper tries 0.01 to 0.1.
    """

    start: _Probability = 0.9
    k: Annotated[float, Field(ge=0)] = 0.03

    def schedule(self, trials: int) -> FloatArray:
        with np.errstate(over="ignore"):
            return np.maximum(self.start - self.k * self._tau(trials), 0.0)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Exponential(_Decay):
    """ε = start·l^(-τ).

    Attributes:
        start: ε at τ = 0.
        l: factor by which ε falls per trial; the paper tries 1 to 10. With l below 1, ε grows to 1.
    """

    start: _Probability = 0.9
    l: Annotated[float, Field(gt=0)] = 2.0  # noqa: E741 (the paper's name)

    def schedule(self, trials: int) -> FloatArray:
        if self.start == 0.0:
            return np.zeros(trials)
        with np.errstate(over="ignore", under="ignore"):
            return np.minimum(self.start * self.l ** -self._tau(trials), 1.0)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Sigmoidal(_Decay):
    """ε = 1 / (1 + e^(-(q - τ)/p)): one half at trial q, falling over about p trials on either side.

    Attributes:
        p: trials over which ε falls.
        q: trial at which ε is one half.
    """

    p: Annotated[float, Field(gt=0)] = 5.0
    q: float = 20.0

    def schedule(self, trials: int) -> FloatArray:
        # tanh is the same curve and saturates where the exponential would overflow.
        with np.errstate(over="ignore"):
            return 0.5 * (1.0 + np.tanh(0.5 * (self.q - self._tau(trials)) / self.p))
