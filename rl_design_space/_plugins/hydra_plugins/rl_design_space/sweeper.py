"""Sweepers that plan design points: `hydra/sweeper=design`, `race`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hydra.core.plugins import Plugins
from hydra.plugins.launcher import Launcher
from hydra.plugins.sweeper import Sweeper
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig


class DesignSweeper(Sweeper):
    """Plans the points of studies and sweep overrides, each once, and runs those that have no complete run.

    Args:
        params: sweep overrides by key; overrides of the command line replace them.
    """

    def __init__(self, params: Mapping[str, str] | None = None) -> None:
        self._params = params or {}
        self._config: DictConfig | None = None
        self._launcher: Launcher | None = None

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """Keep the config, and create the launcher."""
        self._config = config
        self._launcher = Plugins.instance().instantiate_launcher(
            hydra_context=hydra_context, task_function=task_function, config=config
        )

    def sweep(self, arguments: list[str]) -> Any:
        """Run the sweep that these task overrides describe."""
        from rl_design_space.commands.sweep import sweep

        assert self._config is not None
        assert self._launcher is not None
        return sweep(arguments, self._params, self._config, self._launcher)


class RaceSweeper(DesignSweeper):
    """Begins all points of studies and sweep overrides with few periods; those that are worse beyond doubt stop.

    Args:
        params: sweep overrides by key; overrides of the command line replace them.
        first: periods of all points.
        growth: periods at each look, relative to those at the look before.
        confidence: with which the best point is in the set that the race ends with.
    """

    def __init__(
        self,
        params: Mapping[str, str] | None = None,
        first: int = 20,
        growth: float = 1.5,
        confidence: float = 0.95,
    ) -> None:
        super().__init__(params)
        self._rules = {"first": first, "growth": growth, "confidence": confidence}

    def sweep(self, arguments: list[str]) -> Any:
        """Run the race that these task overrides describe."""
        from rl_design_space.commands.race import race

        assert self._config is not None
        assert self._launcher is not None
        return race(arguments, self._params, self._config, self._launcher, self._rules)
