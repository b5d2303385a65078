"""Synthetic results of points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

TRIALS = 20


@dataclass(frozen=True)
class MadeUp:
    """A recorded point: steps fall from `first` to `last` after `until` trials, with noise from period to period."""

    last: float = 10.0
    first: float = 100.0
    until: int = 10
    failed: float = 0.0
    exploration: float = 1.0
    periods: int = 60
    noise: float = 0.05

    @property
    def steps(self) -> np.ndarray:
        curve = np.where(np.arange(TRIALS) < self.until, self.first, self.last)
        spread = 1 + self.noise * np.sin(np.arange(self.periods) * 2.4)
        return np.round(curve * spread[:, np.newaxis]).astype(np.int32)

    @property
    def success(self) -> np.ndarray:
        failing = np.arange(self.periods) < self.failed * self.periods
        return np.broadcast_to(~failing[:, np.newaxis], (self.periods, TRIALS))

    @property
    def over_optimum(self) -> np.ndarray:
        return self.steps / 10

    @property
    def optimum(self) -> np.ndarray:
        return np.full(self.periods, 10, dtype=np.int32)

    @property
    def total_steps(self) -> np.ndarray:
        return self.steps.sum(axis=1, dtype=float)

    @property
    def scaled_steps(self) -> np.ndarray:
        return self.total_steps * 10 / 20

    @property
    def epsilon(self) -> np.ndarray:
        return np.full(TRIALS, self.exploration / TRIALS)

    @cached_property
    def computed(self) -> dict[Any, Any]:
        return {}


@dataclass(frozen=True)
class MadeUpData:
    """Points by name, `{"name": …}`, or groups of them by one parameter."""

    points: Mapping[str, MadeUp]
    groups: Mapping[str, Mapping[Any, MadeUp]] | None = None

    def one(self, where: Mapping[str, Any]) -> MadeUp:
        if where["name"] not in self.points:
            raise LookupError(f"missing: {where['name']}")
        return self.points[where["name"]]

    def by(self, where: Mapping[str, Any], parameter: str) -> Mapping[Any, MadeUp]:
        return (self.groups or {})[where["name"]]
