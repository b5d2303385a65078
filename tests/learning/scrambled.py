"""Actions that do something else at every observation, as a number says: they meet every rule of an action table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rl_design_space.design import Behaviour, SeeingActions


@dataclass(frozen=True, kw_only=True)
class ScrambledActions(SeeingActions):
    """Steps, stops and marks that follow from the observation code, the action and `salt`.

    Attributes:
        salt: another number gives other actions.
        own: number of actions beside the primitive ones; with six, there are no primitive ones.
    """

    salt: int = 0
    own: int = 2

    def __post_init__(self):
        object.__setattr__(self, "primitives", self.own < 6)

    @property
    def names(self):
        return tuple(f"scrambled {number}" for number in range(self.own))

    def behaviour(self, world, representation, goals, codes):
        action = np.arange(self.n_actions, dtype=np.int8).reshape(-1, *[1] * codes.ndim)
        steps = (self._number(codes, 1 + action) % 5).astype(np.int8)
        stops = self._number(codes, 101 + action) % 5 == 0
        if self.primitives:
            steps[:4], stops[:4] = action[:4], False
        return Behaviour(steps, stops, (self._number(codes, 0) % 3).astype(np.int64))

    def _number(self, codes, draw):
        mixed = (codes.astype(np.uint64) ^ np.uint64(self.salt)) * np.uint64(0x9E3779B97F4A7C15)
        mixed = (mixed ^ (mixed >> np.uint64(29)) ^ np.asarray(draw).astype(np.uint64)) * np.uint64(0xBF58476D1CE4E5B9)
        return mixed >> np.uint64(40)
